//! Where the states of two coordinates are, round by round, but for a small chance. Nothing rests on it: what leaves these
//! windows is counted.

use super::pace::Pace;

/// By round and phase: the window of each coordinate; none where no state is expected.
pub(super) type Clouds = Vec<Vec<Option<[(f64, f64); 2]>>>;

/// Where the means may lie, and variances round them.
#[derive(Clone, Copy, Debug)]
struct Cloud {
    first: (f64, f64),
    second: (f64, f64),
    variances: [f64; 2],
    covariance: f64,
}

/// The windows for so many rounds from the last of these phases, which has no state, `wide` standard deviations on each
/// side.
pub(super) fn clouds(phases: &[Vec<Pace>], rounds: u64, wide: f64) -> Clouds {
    let mut all = Vec::new();
    let mut now: Vec<Option<Cloud>> = vec![None; phases.len()];
    if let Some(start) = now.last_mut() {
        *start = Some(Cloud { first: (0.0, 0.0), second: (0.0, 0.0), variances: [0.0; 2], covariance: 0.0 });
    }
    for _ in 0..=rounds + 1 {
        let window = |cloud: &Cloud| {
            let side = |(low, high): (f64, f64), variance: f64| {
                let side = wide * variance.sqrt();
                (low - side, high + side)
            };
            [side(cloud.first, cloud.variances[0]), side(cloud.second, cloud.variances[1])]
        };
        all.push(now.iter().map(|cloud| cloud.as_ref().map(window)).collect());
        let mut next: Vec<Option<Cloud>> = vec![None; phases.len()];
        for (cloud, paces) in now.iter().zip(phases) {
            let Some(cloud) = cloud else { continue };
            for pace in paces.iter().filter(|pace| pace.areas().next().is_some()) {
                let Some(place) = pace.next else { continue };
                let moved = moved(cloud, pace);
                next[place] = Some(next[place].map_or(moved, |old| joined(&old, &moved)));
            }
        }
        now = next;
    }
    all
}

fn moved(cloud: &Cloud, pace: &Pace) -> Cloud {
    let ordered = |one: f64, other: f64| (one.min(other), one.max(other));
    let times = |factor: f64, (low, high): (f64, f64)| ordered(factor * low, factor * high);
    let (kept, leant) = (times(pace.keep, cloud.second), times(pace.lean, cloud.first));
    let [first, second] = cloud.variances;
    let (keep, lean, mixed) = (pace.keep, pace.lean, cloud.covariance);
    Cloud {
        first: ordered(pace.mean(cloud.first.0), pace.mean(cloud.first.1)),
        second: (kept.0 + leant.0 + pace.drift, kept.1 + leant.1 + pace.drift),
        variances: [
            pace.slope.powi(2) * first + pace.sd.powi(2),
            (keep * keep * second + 2.0 * keep * lean * mixed + lean * lean * first).max(0.0) + pace.spread.powi(2),
        ],
        covariance: pace.slope * (keep * mixed + lean * first),
    }
}

fn joined(one: &Cloud, other: &Cloud) -> Cloud {
    let hull = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
    Cloud {
        first: hull(one.first, other.first),
        second: hull(one.second, other.second),
        variances: [0, 1].map(|axis: usize| one.variances[axis].max(other.variances[axis])),
        covariance: one.covariance,
    }
}
