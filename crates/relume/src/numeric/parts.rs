//! A row of texels in equal parts, for means over areas.

/// For each of `to` equal parts of `from` texels, the texels it covers and their shares.
pub fn coverage(from: usize, to: usize) -> Vec<Vec<(usize, f32)>> {
    (0..to)
        .map(|i| {
            // In units of 1 / to texels, so that all bounds are integers.
            let (start, end) = (i * from, (i + 1) * from);
            let share = |k: usize| (end.min((k + 1) * to) - start.max(k * to)) as f32 / from as f32;
            (start / to..end.div_ceil(to)).map(|k| (k, share(k))).collect()
        })
        .collect()
}
