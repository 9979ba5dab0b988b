use std::time::Instant;

use cranny_collision::{Cell, Scratch};
use cranny_spatial::Stream;

/// How hard to shorten a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShortcutSettings {
    /// Random shortcuts to try. Default 60: more gain little.
    pub attempts: usize,
    /// The seed of the random shortcuts.
    pub seed: u64,
}

impl Default for ShortcutSettings {
    fn default() -> Self {
        Self { attempts: 60, seed: 0 }
    }
}

/// A shorter path, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Shortened {
    /// Way points with the same ends; every edge is proven, or a part of an edge of the path given.
    pub path: Vec<Vec<f64>>,
    /// Seconds spent.
    pub time_s: f64,
}

/// Shortens a proven path and keeps the proof: every new edge is proven with the cell's margins before it
/// replaces a detour.
///
/// 1. From each way point on, straight to the farthest later one that can be reached, halving the reach
///    where it cannot.
/// 2. Straight lines between random points of the path, wherever they lie on its edges (Geraerts &
///    Overmars 2007, §3).
///
/// A function of cell, path and settings alone.
///
/// # Panics
/// If a way point has not one value per joint.
pub fn shortcut(cell: &Cell, path: &[Vec<f64>], settings: ShortcutSettings) -> Shortened {
    let begin = Instant::now();
    let mut scratch = cell.scratch();
    let mut path = skip_way_points(cell, path, &mut scratch);
    let mut random = Stream::new(settings.seed, 1);
    for _ in 0..settings.attempts {
        if path.len() < 3 {
            break;
        }
        cut_at_random(cell, &mut path, &mut random, &mut scratch);
    }
    Shortened { path, time_s: begin.elapsed().as_secs_f64() }
}

/// Step 1.
fn skip_way_points(cell: &Cell, path: &[Vec<f64>], scratch: &mut Scratch) -> Vec<Vec<f64>> {
    let mut kept = Vec::new();
    let mut at = 0;
    while at < path.len() {
        kept.push(path[at].clone());
        let mut reach = path.len() - 1 - at;
        while reach > 1 && !is_free(cell, &path[at], &path[at + reach], scratch) {
            reach /= 2;
        }
        at += reach.max(1);
    }
    kept
}

/// Step 2.
fn cut_at_random(cell: &Cell, path: &mut Vec<Vec<f64>>, random: &mut Stream, scratch: &mut Scratch) {
    let lengths: Vec<f64> = path.windows(2).map(|edge| distance(&edge[0], &edge[1])).collect();
    let total: f64 = lengths.iter().sum();
    let (u, v) = (random.uniform() * total, random.uniform() * total);
    let (first, a) = point_at(path, &lengths, u.min(v));
    let (last, b) = point_at(path, &lengths, u.max(v));
    if first == last {
        return;
    }
    let detour = u.max(v) - u.min(v);
    /// A shortcut that saves less than this share of its detour is not worth its proof.
    const LEAST_GAIN: f64 = 0.02;
    if distance(&a, &b) > (1.0 - LEAST_GAIN) * detour || !is_free(cell, &a, &b, scratch) {
        return;
    }
    path.splice(first + 1..=last, [a, b]);
}

/// The edge on which the point at `length` along the path lies, and the point.
fn point_at(path: &[Vec<f64>], lengths: &[f64], length: f64) -> (usize, Vec<f64>) {
    let mut left = length;
    let mut edge = 0;
    while edge + 1 < lengths.len() && left > lengths[edge] {
        left -= lengths[edge];
        edge += 1;
    }
    let at = if lengths[edge] > 0.0 { (left / lengths[edge]).min(1.0) } else { 0.0 };
    (edge, between(&path[edge], &path[edge + 1], at))
}

/// Whether the straight motion is proven; a few looks on the way save the proof where it would fail.
fn is_free(cell: &Cell, a: &[f64], b: &[f64], scratch: &mut Scratch) -> bool {
    [0.5, 0.25, 0.75].iter().all(|at| cell.is_free(&between(a, b, *at), scratch))
        && cell.motion_is_free(a, b, scratch).is_proven()
}

fn between(a: &[f64], b: &[f64], at: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + (b - a) * at).collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
