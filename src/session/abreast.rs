//! The same asked of many things at once, on all cores.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use super::sweep::cores;
use crate::term::room;

/// The fewest things for which other threads are begun.
const FEWEST: usize = 8;
/// How long it is waited for an answer before it is asked whether to stop.
const PATIENCE: Duration = Duration::from_millis(20);

/// What `work` makes of each, in their order; it is told how to ask whether to stop. What it makes must not depend on the
/// thread that it is made in.
pub(super) fn each<T: Sync, R: Send>(
    all: &[T],
    interrupted: &dyn Fn() -> bool,
    work: &(dyn Fn(&T, &dyn Fn() -> bool) -> R + Sync),
) -> Vec<R> {
    let mut found: Vec<Option<R>> = all.iter().map(|_| None).collect();
    if all.len() >= FEWEST && cores() > 1 {
        let (stop, next) = (AtomicBool::new(false), AtomicUsize::new(0));
        let (sender, receiver) = mpsc::channel();
        std::thread::scope(|scope| {
            for _ in 0..cores() {
                let (sender, stop, next, stack) = (sender.clone(), &stop, &next, room::stack());
                let worker = move || {
                    room::tell(stack);
                    while let Some((place, one)) = next_of(all, next) {
                        if sender.send((place, work(one, &|| stop.load(Ordering::Relaxed)))).is_err() {
                            break;
                        }
                    }
                };
                // Where no thread can be begun, what is left is done here.
                let _ = std::thread::Builder::new().stack_size(stack).spawn_scoped(scope, worker);
            }
            drop(sender);
            loop {
                match receiver.recv_timeout(PATIENCE) {
                    Ok((place, one)) => found[place] = Some(one),
                    Err(mpsc::RecvTimeoutError::Timeout) => {}
                    Err(mpsc::RecvTimeoutError::Disconnected) => break,
                }
                if interrupted() {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        });
    }
    all.iter().zip(found).map(|(one, found)| found.unwrap_or_else(|| work(one, interrupted))).collect()
}

fn next_of<'a, T>(all: &'a [T], next: &AtomicUsize) -> Option<(usize, &'a T)> {
    let place = next.fetch_add(1, Ordering::Relaxed);
    Some((place, all.get(place)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_answered_in_its_order_and_hears_that_it_should_stop() {
        let all: Vec<usize> = (0..100).collect();
        let squares = each(&all, &|| false, &|one, stop| (one * one, stop()));
        assert_eq!(squares, all.iter().map(|one| (one * one, false)).collect::<Vec<_>>());
        let stopped = each(&all, &|| true, &|_, stop| {
            while !stop() {
                std::thread::yield_now();
            }
            stop()
        });
        assert_eq!(stopped, vec![true; 100]);
    }
}
