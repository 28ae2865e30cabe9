//! A sink on a thread of its own: the simulation goes on while results are written.

use crate::sink::{Event, RunSink, SinkError};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

/// Samples that may wait to be written; when there are more, the simulation waits.
const QUEUE: usize = 4096;
/// Frames and checkpoints that may wait: those of a large body are large.
const FRAMES: usize = 1;
/// Frames and checkpoints of more bytes than this are waited for: beside the next steps they would take as much
/// memory as the steps themselves, and writing them takes no longer than a step or two.
const AWAITED: usize = 64 << 20;

/// Is dropped when an event has been written.
type Written = SyncSender<()>;

/// Hands everything on to another sink, in order. What that can not store is an error of the next call.
#[derive(Debug)]
pub struct WriterThread {
    folder: PathBuf,
    results: Option<SyncSender<(Event, Option<Written>)>>,
    /// Holds one token for each frame and checkpoint on its way.
    frames: SyncSender<()>,
    thread: Option<JoinHandle<Result<(), SinkError>>>,
}

impl WriterThread {
    /// Before `sink`, which writes to `folder`.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn new(folder: &Path, sink: Box<dyn RunSink>) -> Result<Self, SinkError> {
        let (results, queue) = sync_channel(QUEUE);
        let (frames, written) = sync_channel(FRAMES);
        let thread = std::thread::Builder::new()
            .name("writer".into())
            .spawn(move || write(sink, &queue, &written))
            .map_err(|e| SinkError::io(folder, e))?;
        Ok(Self { folder: folder.to_owned(), results: Some(results), frames, thread: Some(thread) })
    }

    fn send(&mut self, event: Event) -> Result<(), SinkError> {
        let (written, wait) = sync_channel(0);
        let awaited = size(&event) > AWAITED;
        let event = (event, awaited.then_some(written));
        let sent = self.results.as_ref().is_some_and(|results| results.send(event).is_ok());
        if !sent {
            return self.join().and(Err(self.gone()));
        }
        if awaited {
            // Ends when the other end is dropped.
            let _ = wait.recv();
        }
        Ok(())
    }

    /// Waits for everything to be written.
    fn join(&mut self) -> Result<(), SinkError> {
        self.results = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(self.gone()),
            None => Ok(()),
        }
    }

    fn gone(&self) -> SinkError {
        SinkError::new(&self.folder, "the writer has stopped")
    }
}

/// Writes results until the last.
fn write(
    mut sink: Box<dyn RunSink>,
    queue: &Receiver<(Event, Option<Written>)>,
    written: &Receiver<()>,
) -> Result<(), SinkError> {
    for (event, _awaited) in queue {
        if is_large(&event) {
            // The next one may set out while this one is written.
            let _ = written.try_recv();
        }
        sink.take(event)?;
    }
    Ok(())
}

/// Bytes of what is large.
fn size(event: &Event) -> usize {
    let values: usize = match event {
        Event::Frame(frame) => frame.0.columns().map(|(_, column)| column.values().len()).sum(),
        Event::Checkpoint(state) => state.reals().map(|(_, values)| values.len()).sum(),
        _ => 0,
    };
    8 * values
}

/// Whether few of it may wait.
fn is_large(event: &Event) -> bool {
    matches!(event, Event::Frame(_) | Event::Checkpoint(_))
}

impl RunSink for WriterThread {
    fn take(&mut self, event: Event) -> Result<(), SinkError> {
        if is_large(&event) {
            // A writer that has stopped says why when the event is sent.
            let _ = self.frames.send(());
        }
        let last = matches!(event, Event::Finish(_));
        self.send(event)?;
        if last { self.join() } else { Ok(()) }
    }
}

impl Drop for WriterThread {
    fn drop(&mut self) {
        // An error here has no one to go to: the run ends with another.
        let _ = self.join();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rsph_core::simulation::Conservation;

    /// Stores no more than so many samples.
    struct Full(usize);

    impl RunSink for Full {
        fn take(&mut self, event: Event) -> Result<(), SinkError> {
            match event {
                Event::Sample(..) if self.0 == 0 => Err(SinkError::new("probes.csv", "full")),
                Event::Sample(..) => {
                    self.0 -= 1;
                    Ok(())
                }
                _ => Ok(()),
            }
        }
    }

    #[test]
    fn what_can_not_be_written_is_told_sooner_or_later() {
        let mut sink = WriterThread::new(Path::new("out"), Box::new(Full(3))).unwrap();
        let mut sample = || sink.take(Event::Sample(0.0, Vec::new(), Conservation::default()));
        let trouble = (0..100_000).find_map(|_| sample().err()).expect("a full disk");
        assert_eq!((trouble.path.to_str(), &*trouble.message), (Some("probes.csv"), "full"));
    }
}
