//! Work on all threads, results in order.

#[cfg(feature = "rayon")]
pub(crate) fn map_in_order<A: Sync, B: Send>(
    items: &[A],
    map: impl Fn(&A) -> B + Sync + Send,
) -> Vec<B> {
    use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
    items.par_iter().map(map).collect()
}

#[cfg(not(feature = "rayon"))]
pub(crate) fn map_in_order<A, B>(items: &[A], map: impl Fn(&A) -> B) -> Vec<B> {
    items.iter().map(map).collect()
}
