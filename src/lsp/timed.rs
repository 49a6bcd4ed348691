//! Work that may take longer than anybody waits for it.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use crate::lsp::STACK_BYTES;

/// Does one piece of work after the other, each on a thread of its own.
#[derive(Debug)]
pub(super) struct Timed<T> {
    /// The last that took too long. It goes on, for there is no way to stop it.
    left: Option<JoinHandle<T>>,
}

impl<T: Send + 'static> Timed<T> {
    pub(super) fn new() -> Self {
        Timed { left: None }
    }

    /// What comes of some work; `None` if it takes longer than that. No more than one of those is
    /// under way when this returns.
    pub(super) fn within(
        &mut self,
        limit: Duration,
        work: impl Fn() -> T + Send + Sync + 'static,
    ) -> Option<T> {
        let work = Arc::new(work);
        let (done, ended) = mpsc::sync_channel(1);
        let on_thread = Arc::clone(&work);
        let started =
            Builder::new().name("run".to_owned()).stack_size(STACK_BYTES).spawn(move || {
                let result = on_thread();
                let _ = done.send(());
                result
            });
        // Where there is no room for a thread, it takes its time.
        let Ok(thread) = started else { return Some(work()) };
        if ended.recv_timeout(limit) == Err(RecvTimeoutError::Timeout) {
            self.left.replace(thread).map(result_of);
            return None;
        }
        Some(result_of(thread))
    }
}

fn result_of<T>(thread: JoinHandle<T>) -> T {
    thread.join().unwrap_or_else(|panic| resume_unwind(panic))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::thread::sleep;

    use super::*;

    const LONG: Duration = Duration::from_secs(60);

    #[test]
    fn what_takes_too_long_is_left() {
        static RUNNING: AtomicU32 = AtomicU32::new(0);
        let mut timed = Timed::new();
        for n in 0..4 {
            let late = timed.within(Duration::from_millis(1), || {
                RUNNING.fetch_add(1, Ordering::SeqCst);
                sleep(Duration::from_millis(200));
                RUNNING.fetch_sub(1, Ordering::SeqCst);
                7
            });
            assert_eq!(late, None);
            assert!(RUNNING.load(Ordering::SeqCst) <= 1);
            // What comes next does not wait for it.
            assert_eq!(timed.within(LONG, move || n), Some(n));
        }
    }

    #[test]
    #[should_panic(expected = "a bug")]
    fn panics_are_not_lost() {
        Timed::<()>::new().within(LONG, || panic!("a bug"));
    }
}
