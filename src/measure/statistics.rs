//! What a handful of noisy times says: centre, spread, and whether two series differ.
//!
//! All of it goes by ranks, so that neither outliers nor the shape of the distribution matter. The
//! intervals are those of Hollander, Wolfe and Chicken, Nonparametric Statistical Methods (third
//! edition): of the sign test for paired times (3.6), of the rank sum test for others (4.3).

/// Probability that an interval misses, on both sides together.
const ALPHA: f64 = 0.05;

/// Quantile of the normal distribution for `ALPHA`.
const Z: f64 = 1.959_963_984_540_054;

/// Up to this size of both series the distribution of the rank sum is counted out.
const MAX_EXACT: usize = 20;

/// A ratio of times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ratio {
    pub(crate) estimate: f64,
    /// Where the true ratio is, with a confidence of at least 95 %; none from too few times.
    pub(crate) interval: Option<[f64; 2]>,
}

/// What a ratio tells about the later of two things compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Faster,
    Slower,
    WithinNoise,
    TooFewRuns,
}

impl Ratio {
    /// What may be said of it.
    pub(crate) fn verdict(self) -> Verdict {
        match self.interval {
            None => Verdict::TooFewRuns,
            Some([_, high]) if high < 1.0 => Verdict::Faster,
            Some([low, _]) if low > 1.0 => Verdict::Slower,
            Some(_) => Verdict::WithinNoise,
        }
    }
}

impl Verdict {
    pub(crate) fn words(self) -> &'static str {
        match self {
            Verdict::Faster => "faster",
            Verdict::Slower => "slower",
            Verdict::WithinNoise => "no difference within noise",
            Verdict::TooFewRuns => "too few runs to tell",
        }
    }
}

/// The mean; NaN of nothing.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The standard deviation of a sample; none of fewer than two values.
pub(crate) fn standard_deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

/// The median; NaN of nothing.
pub(crate) fn median(values: &[f64]) -> f64 {
    let sorted = sorted(values);
    match sorted.len() {
        0 => f64::NAN,
        n => sorted[(n - 1) / 2].midpoint(sorted[n / 2]),
    }
}

/// The median of the absolute deviations from the median.
pub(crate) fn median_absolute_deviation(values: &[f64]) -> f64 {
    let center = median(values);
    median(&values.iter().map(|value| (value - center).abs()).collect::<Vec<_>>())
}

/// Ratio of times that were taken in the same rounds: the median of the rounds' ratios.
pub(crate) fn paired_ratio(base: &[f64], times: &[f64]) -> Ratio {
    let ratios =
        sorted(&times.iter().zip(base).map(|(time, base)| time / base).collect::<Vec<_>>());
    let interval = sign_rank(ratios.len()).map(|k| [ratios[k - 1], ratios[ratios.len() - k]]);
    Ratio { estimate: median(&ratios), interval }
}

/// The largest `k` such that the `k`th smallest and the `k`th largest of `n` values enclose the
/// median with the confidence asked for: half of a fair coin's `n` throws.
fn sign_rank(n: usize) -> Option<usize> {
    let mut ln_probability = n as f64 * 0.5_f64.ln();
    let mut below = 0.0;
    for k in 0..=n {
        below += ln_probability.exp();
        if below > ALPHA / 2.0 {
            return (k > 0).then_some(k);
        }
        ln_probability += ((n - k) as f64 / (k + 1) as f64).ln();
    }
    None
}

/// Ratio of times of two occasions: the median of all ratios of one to the other.
pub(crate) fn unpaired_ratio(base: &[f64], times: &[f64]) -> Ratio {
    let pairs = Pairs { base: sorted(base), times: sorted(times) };
    let n_pairs = base.len() * times.len();
    if n_pairs == 0 {
        return Ratio { estimate: f64::NAN, interval: None };
    }
    let estimate = pairs.ratio(n_pairs.div_ceil(2)).midpoint(pairs.ratio(n_pairs / 2 + 1));
    let interval = rank_sum_rank(base.len(), times.len())
        .map(|k| [pairs.ratio(k), pairs.ratio(n_pairs + 1 - k)]);
    Ratio { estimate, interval }
}

/// The ratios of all times to all others, which may be too many to be written down.
struct Pairs {
    base: Vec<f64>,
    times: Vec<f64>,
}

impl Pairs {
    /// The `k`th smallest ratio, from 1. Positive doubles are in the order of their bits.
    fn ratio(&self, k: usize) -> f64 {
        let (mut low, mut high) = (0, f64::INFINITY.to_bits());
        while low < high {
            let middle = low + (high - low) / 2;
            if self.n_up_to(f64::from_bits(middle)) >= k {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        f64::from_bits(low)
    }

    /// Number of ratios that are at most this one.
    fn n_up_to(&self, ratio: f64) -> usize {
        let mut n_times = 0;
        let count = |base: &f64| {
            n_times +=
                self.times[n_times..].iter().take_while(|&time| time / base <= ratio).count();
            n_times
        };
        self.base.iter().map(count).sum()
    }
}

/// The largest `k` such that the `k`th smallest and the `k`th largest of all `m n` ratios enclose
/// the true one with the confidence asked for.
fn rank_sum_rank(m: usize, n: usize) -> Option<usize> {
    if m.max(n) > MAX_EXACT {
        let (m, n) = (m as f64, n as f64);
        let k = (m * n / 2.0 - Z * (m * n * (m + n + 1.0) / 12.0).sqrt()).floor();
        return (k >= 1.0).then_some(k as usize);
    }
    let counts = rank_sum_counts(m, n);
    let total: f64 = counts.iter().sum();
    let mut below = 0.0;
    let k = counts.iter().take_while(|&&count| {
        below += count;
        below <= total * ALPHA / 2.0
    });
    Some(k.count()).filter(|&k| k > 0)
}

/// Of all orders of `m` and `n` values, how many have so many pairs in which the second is smaller:
/// the coefficients of the Gaussian binomial, the product of `(1 - q^(n + i)) / (1 - q^i)`.
fn rank_sum_counts(m: usize, n: usize) -> Vec<f64> {
    let mut counts = vec![0.0; m * n + 1];
    counts[0] = 1.0;
    for i in 1..=m {
        for degree in (n + i..counts.len()).rev() {
            counts[degree] -= counts[degree - n - i];
        }
        for degree in i..counts.len() {
            counts[degree] += counts[degree - i];
        }
    }
    counts
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centre_and_spread() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 100.0]), 3.0);
        assert!(median(&[]).is_nan());
        // The deviations from 3 are 2, 1, 0, 1, 97.
        assert_eq!(median_absolute_deviation(&[1.0, 2.0, 3.0, 4.0, 100.0]), 1.0);
        // The deviations from 5 have the squares 9, 1, 1, 1, 0, 0, 4, 16.
        let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
        assert_eq!(mean(&values), 5.0);
        assert_eq!(standard_deviation(&values), Some((32.0_f64 / 7.0).sqrt()));
        assert_eq!(standard_deviation(&[1.0]), None);
    }

    /// From sums of binomial coefficients: of 10 throws at most one shows heads with probability
    /// 11 / 1024, at most two with 56 / 1024.
    #[test]
    fn ranks_of_the_sign_test() {
        let table = [(0, None), (5, None), (6, Some(1)), (8, Some(1)), (9, Some(2)), (10, Some(2))];
        for (n, rank) in table {
            assert_eq!(sign_rank(n), rank, "{n}");
        }
        // As tabulated for larger samples; then by the normal distribution.
        assert_eq!((sign_rank(20), sign_rank(25), sign_rank(100)), (Some(6), Some(8), Some(40)));
        let approximate = 50_000.0 - Z * 25_000.0_f64.sqrt();
        assert!((sign_rank(100_000).expect("many") as f64 - approximate).abs() < 2.0);
    }

    #[test]
    fn paired_ratios_compare_rounds() {
        let base = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
        let twice = paired_ratio(&base, &base.map(|time| 2.0 * time));
        assert_eq!(twice, Ratio { estimate: 2.0, interval: Some([2.0, 2.0]) });
        assert_eq!(twice.verdict(), Verdict::Slower);
        let factors = [0.8, 0.9, 0.7, 1.1, 0.95, 0.6, 0.85];
        let mixed: Vec<_> = base.iter().zip(factors).map(|(time, factor)| time * factor).collect();
        let ratio = paired_ratio(&base, &mixed);
        assert!((ratio.estimate - 0.85).abs() < 1e-15);
        assert_eq!((ratio.interval, ratio.verdict()), (Some([0.6, 1.1]), Verdict::WithinNoise));
        assert_eq!(paired_ratio(&base[..5], &mixed[..5]).verdict(), Verdict::TooFewRuns);
    }

    /// Orders of 2 and 3 values, counted by hand; critical values from tables of the U test.
    #[test]
    fn ranks_of_the_rank_sum_test() {
        assert_eq!(rank_sum_counts(2, 3), [1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0]);
        assert_eq!(rank_sum_counts(20, 20).iter().sum::<f64>(), 137_846_528_820.0);
        let table = [(3, 4, None), (4, 4, Some(1)), (5, 5, Some(3)), (8, 8, Some(14))];
        for (m, n, rank) in table {
            assert_eq!(rank_sum_rank(m, n), rank, "{m} {n}");
        }
        assert_eq!((rank_sum_rank(10, 10), rank_sum_rank(20, 20)), (Some(24), Some(128)));
        let approximate = rank_sum_rank(21, 21).expect("many");
        assert!((138..=144).contains(&approximate), "{approximate}");
        assert_eq!(rank_sum_rank(1, 10_000), None);
    }

    #[test]
    fn unpaired_ratios_compare_all_with_all() {
        let pairs = Pairs { base: vec![1.0, 2.0], times: vec![2.0, 3.0, 8.0] };
        let ratios: Vec<_> = (1..=6).map(|k| pairs.ratio(k)).collect();
        assert_eq!(ratios, [1.0, 1.5, 2.0, 3.0, 4.0, 8.0]);
        let ratio = unpaired_ratio(&[1.0, 2.0], &[2.0, 3.0, 8.0]);
        assert_eq!(ratio, Ratio { estimate: 2.5, interval: None });
        let base = [1.0, 1.1, 1.2, 1.3, 1.4];
        let ratio = unpaired_ratio(&base, &base.map(|time| time / 2.0));
        assert_eq!((ratio.estimate, ratio.verdict()), (0.5, Verdict::Faster));
        assert_eq!(unpaired_ratio(&base, &base).verdict(), Verdict::WithinNoise);
    }
}
