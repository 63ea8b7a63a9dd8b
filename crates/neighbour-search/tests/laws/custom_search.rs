//! A search as a user would write it, behind the same trait.

use neighbour_search::{BruteForce, CellGrid, Error, NeighbourList, NeighbourSearch, Radii};

/// Searches once and keeps the list while no point has moved by more than half of the skin.
#[derive(Debug, Default)]
struct Reusing<const D: usize> {
    grid: CellGrid<D>,
    built_at: Vec<[f64; D]>,
    wide: NeighbourList,
    builds: usize,
}

const SKIN: f64 = 0.25;

impl<const D: usize> NeighbourSearch<D> for Reusing<D> {
    fn full_list(
        &mut self,
        points: &[[f64; D]],
        radii: Radii<'_>,
        list: &mut NeighbourList,
    ) -> Result<(), Error> {
        let radii = match radii {
            Radii::Uniform(radius) => Radii::Uniform(radius + SKIN),
            Radii::PerPoint { .. } => radii,
        };
        let moved = |(a, b): (&[f64; D], &[f64; D])| {
            a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let stale = self.built_at.len() != points.len()
            || self.built_at.iter().zip(points).any(|pair| moved(pair) > 0.5 * SKIN);
        if stale {
            self.grid.full_list(points, radii, &mut self.wide)?;
            self.built_at = points.to_vec();
            self.builds += 1;
        }
        list.clone_from(&self.wide);
        Ok(())
    }
}

/// Number of unordered pairs within a radius, as a solver counts them: generic in the search, filtering in the visitor.
fn contacts<const D: usize, S: NeighbourSearch<D>>(
    search: &mut S,
    points: &[[f64; D]],
    radius: f64,
) -> Result<usize, Error> {
    let mut list = NeighbourList::new();
    search.full_list(points, Radii::Uniform(radius), &mut list)?;
    let mut contacts = 0;
    list.for_each_pair(points, |pair| {
        contacts += usize::from(pair.i < pair.j && pair.r <= radius);
    })?;
    Ok(contacts)
}

#[test]
fn users_search_serves_a_solver_in_place_of_ours() -> Result<(), Error> {
    // A chain of 10 at unit spacing: 9 contacts within 1.1, and after a small shift of one end 8 within 1.0 at most.
    let mut chain: Vec<[f64; 3]> = (0..10).map(|k| [f64::from(k), 0.0, 0.0]).collect();
    let mut reusing = Reusing::default();
    assert_eq!(contacts(&mut reusing, &chain, 1.0)?, 9);
    chain[9][0] += 0.1;
    assert_eq!(contacts(&mut reusing, &chain, 1.0)?, 8);
    assert_eq!(contacts(&mut BruteForce::new(), &chain, 1.0)?, 8);
    assert_eq!(reusing.builds, 1, "a shift below half of the skin reuses the list");
    chain[9][0] += 0.1;
    assert_eq!(contacts(&mut reusing, &chain, 1.0)?, 8);
    assert_eq!(reusing.builds, 2);
    Ok(())
}
