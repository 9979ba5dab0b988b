use cranny_collision::{Body, Part};
use cranny_shape::{Aabb, BoxUnion, Solid};
use cranny_spatial::{Point, Pose, Rotation, Vector};
use rayon::prelude::*;

use crate::seen::cell_merge::boxes_of;
use crate::seen::known_solids::{Explained, KnownBody, KnownScene, KnownSolids, Nearness};
use crate::seen::sight::{Judgement, Sight};
use crate::{SenseError, View};

/// Settings of a map of seen space.
#[derive(Clone, Debug)]
pub struct SeenSettings {
    /// Region of the planning frame that is mapped; all space outside of it counts as unseen.
    pub region: Aabb,
    /// Side of the smallest cells, in metres.
    pub cell_m: f64,
    /// Boxes in which the smallest cells are narrower.
    pub fine: Vec<Aabb>,
    /// Side of the smallest cells there, in metres.
    pub fine_m: f64,
    /// Treatment of unseen space.
    pub unseen: Unseen,
}

/// Treatment of space that no camera has seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unseen {
    /// It is an obstacle.
    Solid,
    /// It is free: what others assume, for comparison.
    Free,
}

/// Map of the space that cameras have seen: a cell is free only if one view shows that nothing is in it, within the bounds of its
/// sensor. The free part is thus an under-estimate.
#[derive(Clone, Debug)]
pub struct SeenMap {
    settings: SeenSettings,
    /// Cells in which a surface may have been measured.
    occupied: Vec<Aabb>,
    /// Cells that no camera has seen into.
    unseen: Vec<Aabb>,
    detail_m: [f64; 2],
    layer_m: [f64; 2],
}

/// Cells of one kind in a cube: all, none, or some, which are then listed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Free,
    Occupied,
    Unseen,
    Mixed,
}

/// Halvings of the cubes with which the search begins: 16 cells along each side.
const HALVINGS: u32 = 4;

/// Maximum number of cubes with which the search begins: 10 m × 10 m × 10 m of cells of 1 cm.
const MOST_CUBES: f64 = 262_144.0;

impl SeenMap {
    /// Name of the body that stands for measured surfaces.
    pub const OCCUPIED: &str = "occupied";
    /// Name of the body that stands for unseen space.
    pub const UNSEEN: &str = "unseen";

    /// Returns true if a body of this name stands for a part of a map.
    pub fn is_name_of_map(name: &str) -> bool {
        [Self::OCCUPIED, Self::UNSEEN].contains(&name)
    }

    /// Maps a region as these views show it, with the known bodies where they are in all of them.
    ///
    /// # Errors
    /// As [`Self::of_moving`].
    pub fn new(views: &[View], known: &[KnownBody], settings: SeenSettings) -> Result<Self, SenseError> {
        Self::of_moving(views, known, &[], settings)
    }

    /// Maps a region as these views show it. `known` are the known bodies where they are when the motion begins, `shown` for each
    /// view (or for none) all of them where they were in it, if that is elsewhere.
    ///
    /// # Errors
    /// [`SenseError::NoViews`] without views, [`SenseError::Map`] for a region or cell out of range, [`SenseError::NoSurface`] for a
    /// known body that cannot be rendered.
    pub fn of_moving(
        views: &[View],
        known: &[KnownBody],
        shown: &[Option<Vec<KnownBody>>],
        settings: SeenSettings,
    ) -> Result<Self, SenseError> {
        if views.is_empty() {
            return Err(SenseError::NoViews);
        }
        let Cubes { counts: [x, y, z], side_m: cube_m } = Cubes::of(&settings)?;
        let SeenSettings { region, cell_m, fine, fine_m, .. } = &settings;
        let has_fine = !fine.is_empty();
        let scene = KnownScene::new(known)?;
        let moved = shown.iter().map(|bodies| bodies.as_deref().map(KnownScene::new).transpose());
        let elsewhere = moved.collect::<Result<Vec<_>, _>>()?;
        let sight = |(index, view): (usize, &View)| {
            let scene = elsewhere.get(index).and_then(Option::as_ref).unwrap_or(&scene);
            Sight::new(view, &Explained::of(view, scene), has_fine)
        };
        let sights: Vec<Sight> = views.par_iter().enumerate().map(sight).collect();
        let survey = Survey {
            sights,
            known: KnownSolids::new(known),
            half_m: 0.5 * cell_m,
            fine: fine.clone(),
            fine_half_m: 0.5 * fine_m,
        };
        let low = region.low();
        if let Some(view) = views.iter().find(|view| !Sight::is_sharp(view)) {
            let problem = format!(
                "view '{}' shows no space to be free: with its focal length and lateral error, a pixel may see things as far \
                 from its ray as a third of their depth",
                view.name
            );
            return Err(SenseError::Map { problem });
        }
        let (views, solids) = ((0..survey.sights.len()).collect::<Vec<_>>(), survey.known.all());
        let cubes = (0..x * y * z).into_par_iter().map(|index| {
            let place = Vector::new((index / (y * z)) as f64, (index / z % y) as f64, (index % z) as f64);
            let center = low + (place + Vector::repeat(0.5)) * cube_m;
            let mut cells = Cells::default();
            let half_m = 0.5 * cube_m;
            let kind = survey.visit(&center, half_m, &views, Some(&solids), &mut cells);
            cells.add(kind, Aabb { center, half_extents: Vector::repeat(half_m) });
            cells
        });
        let cubes: Vec<Cells> = cubes.collect();
        let collected = |of: fn(&Cells) -> &Vec<Aabb>| cubes.iter().flat_map(of).copied().collect();
        let tolerance_m = known.iter().map(|body| body.tolerance_m).fold(0.0, f64::max);
        // The cubes may reach beyond the region, and cells judged as fine ones beyond the fine boxes.
        let mapped = Vector::new(x as f64, y as f64, z as f64) * cube_m;
        let region = Aabb { center: low + mapped * 0.5, half_extents: mapped * 0.5 };
        let fine: Vec<Aabb> = settings.fine.iter().map(|aabb| aabb.grown(2.0 * settings.cell_m)).collect();
        let [everywhere, beside] = [std::slice::from_ref(&region), &fine[..]].map(|boxes| {
            let missed = boxes.iter().flat_map(corners).flat_map(|corner| {
                survey.sights.iter().map(move |sight| {
                    let depth_m = sight.depth_m(&corner).max(0.0);
                    [sight.detail_m(depth_m), sight.layer_m(depth_m, tolerance_m)]
                })
            });
            missed.fold([[0.0_f64; 2]; 2], |[a, b], [c, d]| {
                let greater = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
                [greater(a, c), greater(b, d)]
            })
        });
        Ok(Self {
            settings: SeenSettings { region, ..settings },
            occupied: collected(|cells| &cells.occupied),
            unseen: collected(|cells| &cells.unseen),
            detail_m: [everywhere[0][0], beside[0][1]],
            layer_m: [everywhere[1][0], beside[1][1]],
        })
    }

    /// Returns the settings, with the region that is mapped: a whole number of cubes.
    pub fn settings(&self) -> &SeenSettings {
        &self.settings
    }

    /// Returns the boxes of cells in which a surface may have been measured.
    pub fn occupied(&self) -> &[Aabb] {
        &self.occupied
    }

    /// Returns the boxes of cells within the region that no camera has seen into.
    pub fn unseen(&self) -> &[Aabb] {
        &self.unseen
    }

    /// Returns the greatest diameter of details that can be missed: within the region, and within its fine boxes (m).
    pub fn detail_m(&self) -> [f64; 2] {
        self.detail_m
    }

    /// Returns the thickness of the layer at the surface of a known body in which nothing else is distinguished from it: within the
    /// region, and within its fine boxes (m).
    pub fn layer_m(&self) -> [f64; 2] {
        self.layer_m
    }

    /// Returns the volume of the region that is no obstacle of the map, in cubic metres: what is seen to be free, and the inside of
    /// known bodies, such as below the floor.
    pub fn free_m3(&self) -> f64 {
        let volume = |aabb: &Aabb| 8.0 * aabb.half_extents.product();
        let taken: f64 = self.occupied.iter().chain(&self.unseen).map(volume).sum();
        volume(&self.settings.region) - taken
    }

    /// Returns the obstacles that the map stands for: the body [`OCCUPIED`](Self::OCCUPIED) and, if unseen space is solid, the body
    /// [`UNSEEN`](Self::UNSEEN), with all space outside the region.
    ///
    /// # Errors
    /// [`SenseError::Shape`] for a region too far away.
    pub fn bodies(&self) -> Result<Vec<Body>, SenseError> {
        let union = |cells: &[Aabb]| -> Result<Option<Part>, SenseError> {
            if cells.is_empty() {
                return Ok(None);
            }
            // Coordinates from the middle of the region keep single precision exact to less than a micrometre.
            let middle = self.settings.region.center.coords;
            let moved = cells.iter().map(|cell| Aabb { center: cell.center - middle, ..*cell });
            let solid = Solid::union(BoxUnion::of_boxes(moved)?);
            Ok(Some(Part { world_from_solid: Pose::from_parts(middle.into(), Rotation::identity()), solid }))
        };
        let mut bodies = Vec::new();
        let mut add = |name: &str, parts: Vec<Part>| {
            if !parts.is_empty() {
                bodies.push(Body { name: name.to_owned(), parts, tilt_rad: None, center_of_mass: None });
            }
        };
        add(Self::OCCUPIED, union(&self.occupied)?.into_iter().collect());
        if self.settings.unseen == Unseen::Solid {
            let mut parts: Vec<Part> = union(&self.unseen)?.into_iter().collect();
            parts.extend(self.outside()?);
            add(Self::UNSEEN, parts);
        }
        Ok(bodies)
    }

    /// Returns walls around the region, thick enough for any motion.
    fn outside(&self) -> Result<Vec<Part>, SenseError> {
        /// Thickness of the walls, in metres.
        const WALL_M: f64 = 50.0;
        let Aabb { center, half_extents } = self.settings.region;
        let mut walls = Vec::new();
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let mut half = half_extents + Vector::repeat(2.0 * WALL_M);
                half[axis] = WALL_M;
                let mut middle = center.coords;
                middle[axis] += side * (half_extents[axis] + WALL_M);
                let solid = Solid::cuboid(half)?;
                walls.push(Part {
                    world_from_solid: Pose::from_parts(middle.into(), Rotation::identity()),
                    solid,
                });
            }
        }
        Ok(walls)
    }
}

/// Cubes with which the search begins: their number along each axis, and their side.
struct Cubes {
    counts: [usize; 3],
    side_m: f64,
}

impl Cubes {
    /// # Errors
    /// [`SenseError::Map`] for a region or cell out of range.
    fn of(settings: &SeenSettings) -> Result<Self, SenseError> {
        let SeenSettings { region, cell_m, fine_m, .. } = settings;
        let fault = |problem: String| Err(SenseError::Map { problem });
        for side_m in [cell_m, fine_m] {
            if !(1e-3..=0.2).contains(side_m) {
                return fault(format!("its cells must be 0.001 to 0.2 m wide, but are {side_m} m"));
            }
        }
        let is_region = region.center.iter().all(|x| x.abs() <= 100.0)
            && region.half_extents.iter().all(|x| *x > 0.0 && *x <= 100.0);
        if !is_region {
            return fault("its region must be a box of positive size within 100 m".to_owned());
        }
        let side_m = cell_m * f64::from(1_u32 << HALVINGS);
        let counts = region.half_extents.map(|half| (2.0 * half / side_m).ceil().max(1.0));
        if counts.product() > MOST_CUBES {
            return fault(format!(
                "its region holds more than {MOST_CUBES} cubes of {side_m} m (take larger cells or a smaller region)"
            ));
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small whole numbers")]
        let counts = [0, 1, 2].map(|axis| counts[axis] as usize);
        Ok(Self { counts, side_m })
    }
}

/// Boxes of the two kinds that obstruct.
#[derive(Clone, Debug, Default)]
struct Cells {
    occupied: Vec<Aabb>,
    unseen: Vec<Aabb>,
}

impl Cells {
    fn add(&mut self, kind: Kind, aabb: Aabb) {
        match kind {
            Kind::Occupied => self.occupied.push(aabb),
            Kind::Unseen => self.unseen.push(aabb),
            Kind::Free | Kind::Mixed => {}
        }
    }
}

/// All that cells are judged by.
struct Survey {
    sights: Vec<Sight>,
    known: KnownSolids,
    /// Half side of the smallest cells, in metres.
    half_m: f64,
    /// Boxes in which it is less, and the half side there.
    fine: Vec<Aabb>,
    fine_half_m: f64,
}

impl Survey {
    /// Returns the kind of a cube. The boxes of a mixed one are added to `cells`, those of any other are left to the caller. Smaller
    /// cubes are judged by the views in which they may be free alone. `near` are known solids that may be near; `None` within reach
    /// of one.
    fn visit(
        &self,
        center: &Point,
        half_m: f64,
        views: &[usize],
        near: Option<&[usize]>,
        cells: &mut Cells,
    ) -> Kind {
        let is_fine =
            half_m < 5.0 * self.half_m && self.fine.iter().any(|fine| fine.distance_to(center) <= 0.0);
        let (mut open, mut is_open) = (Vec::with_capacity(views.len()), false);
        for &view in views {
            match self.sights[view].judge(center, half_m, is_fine) {
                Judgement::Free => return Kind::Free,
                Judgement::Hidden => {}
                Judgement::Blocked => open.push(view),
                Judgement::Open => {
                    is_open = true;
                    open.push(view);
                }
            }
        }
        let shows = |but_known: bool| {
            open.iter().any(|view| self.sights[*view].shows_surface(center, half_m, but_known))
        };
        // The borders of shadows and images, and the labels of cells that cannot be free, need no smallest cells.
        let least_m = if is_fine { self.fine_half_m } else { self.half_m };
        let is_small = half_m < 3.0 * least_m;
        let is_least = half_m < 1.5 * least_m || (is_small && !(is_open && (is_fine || shows(false))));
        let nearness = near.map(|near| self.known.nearness(center, half_m, near));
        let near = match &nearness {
            // Nothing else is inside of it.
            Some(Nearness::Within(true)) => return Kind::Free,
            None | Some(Nearness::Within(false)) => None,
            Some(Nearness::Beyond) => Some(&[][..]),
            Some(Nearness::Partly(near)) => Some(&near[..]),
        };
        // At the end of the reach of some bodies, cells are halved further.
        let border_m =
            near.filter(|_| is_least && is_fine).and_then(|near| self.known.border_m(center, half_m, near));
        let is_at_end = border_m.is_some_and(|border_m| half_m <= 0.5 * border_m + 1e-9);
        let is_exempt = near.is_none();
        if is_at_end || (is_exempt && !shows(true)) {
            return Kind::Free;
        }
        let is_touched = is_least && self.known.touches_alone(center, half_m);
        if is_touched && half_m < 1.5 * least_m {
            return Kind::Free;
        }
        if is_least && !is_touched && border_m.is_none() {
            return if is_exempt || shows(false) { Kind::Occupied } else { Kind::Unseen };
        }
        if open.is_empty() && near.is_some_and(<[usize]>::is_empty) {
            return Kind::Unseen;
        }
        let mut kinds = [Kind::Free; 8];
        let half = 0.5 * half_m;
        let child = |index: usize| {
            let sign = |bit: usize| if index & bit == 0 { -half } else { half };
            center + Vector::new(sign(1), sign(2), sign(4))
        };
        for (index, kind) in kinds.iter_mut().enumerate() {
            *kind = self.visit(&child(index), half, &open, near, cells);
        }
        if kinds.iter().all(|kind| *kind == kinds[0]) && kinds[0] != Kind::Mixed {
            return kinds[0];
        }
        for wanted in [Kind::Occupied, Kind::Unseen] {
            let bits = (0..8).fold(0, |bits, index| bits | u8::from(kinds[index] == wanted) << index);
            for [first, size] in boxes_of(bits) {
                let of = |axis: usize| {
                    let (first, size) = (f64::from(first[axis]), f64::from(size[axis]));
                    (half_m * (first + 0.5 * size - 1.0), 0.5 * half_m * size)
                };
                let [x, y, z] = [of(0), of(1), of(2)];
                let center = center + Vector::new(x.0, y.0, z.0);
                cells.add(wanted, Aabb { center, half_extents: Vector::new(x.1, y.1, z.1) });
            }
        }
        Kind::Mixed
    }
}

/// Corners of a box.
fn corners(aabb: &Aabb) -> [Point; 8] {
    std::array::from_fn(|corner| {
        let sign = |bit: usize| if corner & bit == 0 { -1.0 } else { 1.0 };
        aabb.center + aabb.half_extents.component_mul(&Vector::new(sign(1), sign(2), sign(4)))
    })
}
