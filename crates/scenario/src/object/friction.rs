use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::ObjectError;
use crate::object::error::check_number;

/// Coefficient of friction between an object and what touches it: the range in which it lies. Loads are computed, and motions
/// simulated, at its lower end; a simulation with random errors draws from the range.
///
/// In files it is a number, or the two ends of a range: `0.5`, `[0.35, 0.6]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Lower end; positive.
    pub low: f64,
    /// Upper end, at least the lower one.
    pub high: f64,
}

impl Friction {
    /// Checks that the range is positive and not empty.
    ///
    /// # Errors
    /// [`ObjectError::Number`].
    pub fn check(self) -> Result<Self, ObjectError> {
        check_number("friction", self.low)?;
        check_number("friction", self.high)?;
        if self.low <= self.high {
            return Ok(self);
        }
        Err(ObjectError::Friction { low: self.low, high: self.high })
    }

    /// Returns true if the range is more than one number.
    pub fn is_range(&self) -> bool {
        self.high > self.low
    }
}

impl From<f64> for Friction {
    fn from(coefficient: f64) -> Self {
        Self { low: coefficient, high: coefficient }
    }
}

impl fmt::Display for Friction {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        if self.is_range() {
            write!(formatter, "{} to {}", self.low, self.high)
        } else {
            self.low.fmt(formatter)
        }
    }
}

/// Reads `0.5` or `0.35..0.6`.
impl FromStr for Friction {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| {
            text.parse().map_err(|_| "a coefficient such as 0.5, or a range such as 0.35..0.6".to_owned())
        };
        let friction = match text.split_once("..") {
            Some((low, high)) => Self { low: number(low)?, high: number(high)? },
            None => number(text)?.into(),
        };
        friction.check().map_err(|fault| fault.to_string())
    }
}

impl Serialize for Friction {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.is_range() {
            [self.low, self.high].serialize(serializer)
        } else {
            self.low.serialize(serializer)
        }
    }
}

impl<'de> Deserialize<'de> for Friction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FrictionVisitor)
    }
}

/// Visitor of a friction; an untagged enum would lose the line of the value.
struct FrictionVisitor;

impl<'de> Visitor<'de> for FrictionVisitor {
    type Value = Friction;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a coefficient of friction, or the two ends of its range")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Friction, E> {
        Ok(value.into())
    }

    #[allow(clippy::cast_precision_loss, reason = "no friction is so great that digits are lost")]
    fn visit_i64<E: Error>(self, value: i64) -> Result<Friction, E> {
        Ok((value as f64).into())
    }

    #[allow(clippy::cast_precision_loss, reason = "no friction is so great that digits are lost")]
    fn visit_u64<E: Error>(self, value: u64) -> Result<Friction, E> {
        Ok((value as f64).into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<Friction, A::Error> {
        let mut end = |index| values.next_element()?.ok_or_else(|| A::Error::invalid_length(index, &self));
        let (low, high) = (end(0)?, end(1)?);
        if values.next_element::<f64>()?.is_some() {
            return Err(A::Error::invalid_length(3, &self));
        }
        Ok(Friction { low, high })
    }
}

impl JsonSchema for Friction {
    fn schema_name() -> Cow<'static, str> {
        "Friction".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A coefficient of friction, or the lower and the upper end of its range; positive.",
            "anyOf": [
                { "type": "number" },
                { "type": "array", "items": { "type": "number" }, "minItems": 2, "maxItems": 2 },
            ],
        })
    }
}
