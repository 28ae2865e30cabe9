//! A sink on a thread of its own: the simulation goes on while results are written.

use crate::sink::{Outcome, RunSink, SinkError};
use rsph_core::simulation::{Conservation, Reading};
use rsph_core::snapshot::Snapshot;
use rsph_core::state::State;
use rsph_core::surface::Surface;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

/// Samples that may wait to be written; when there are more, the simulation waits.
const QUEUE: usize = 4096;
/// Frames and checkpoints that may wait: those of a large body are large.
const FRAMES: usize = 1;

/// A result on its way.
enum Message {
    Frame(Box<(Snapshot, Surface, Conservation)>),
    Sample(f64, Vec<Reading>, Box<Conservation>),
    Tick,
    Checkpoint(State),
    Wreck(Box<Snapshot>),
    Finish(Box<Outcome>),
}

/// Hands everything on to another sink, in order. What that can not store is an error of the next call.
#[derive(Debug)]
pub struct WriterThread {
    folder: PathBuf,
    results: Option<SyncSender<Message>>,
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

    fn send(&mut self, message: Message) -> Result<(), SinkError> {
        let sent = self.results.as_ref().is_some_and(|results| results.send(message).is_ok());
        if sent { Ok(()) } else { self.join().and(Err(self.gone())) }
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
    queue: &Receiver<Message>,
    written: &Receiver<()>,
) -> Result<(), SinkError> {
    for message in queue {
        match message {
            Message::Frame(frame) => {
                // The next one may set out while this one is written.
                let _ = written.try_recv();
                sink.frame(&frame.0, &frame.1, &frame.2)?;
            }
            Message::Sample(time, readings, conservation) => sink.sample(time, &readings, &conservation)?,
            Message::Tick => sink.tick()?,
            Message::Checkpoint(state) => {
                let _ = written.try_recv();
                sink.checkpoint(state)?;
            }
            Message::Wreck(snapshot) => sink.wreck(&snapshot)?,
            Message::Finish(outcome) => sink.finish(&outcome)?,
        }
    }
    Ok(())
}

impl RunSink for WriterThread {
    fn frame(
        &mut self,
        snapshot: &Snapshot,
        surface: &Surface,
        conservation: &Conservation,
    ) -> Result<(), SinkError> {
        // A writer that has stopped says why when the frame is sent.
        let _ = self.frames.send(());
        self.send(Message::Frame(Box::new((snapshot.clone(), surface.clone(), *conservation))))
    }

    fn sample(
        &mut self,
        time: f64,
        readings: &[Reading],
        conservation: &Conservation,
    ) -> Result<(), SinkError> {
        self.send(Message::Sample(time, readings.to_vec(), Box::new(*conservation)))
    }

    fn tick(&mut self) -> Result<(), SinkError> {
        self.send(Message::Tick)
    }

    fn checkpoint(&mut self, state: State) -> Result<(), SinkError> {
        let _ = self.frames.send(());
        self.send(Message::Checkpoint(state))
    }

    fn wreck(&mut self, snapshot: &Snapshot) -> Result<(), SinkError> {
        self.send(Message::Wreck(Box::new(snapshot.clone())))
    }

    fn finish(&mut self, outcome: &Outcome) -> Result<(), SinkError> {
        self.send(Message::Finish(Box::new(outcome.clone())))?;
        self.join()
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

    /// Stores no more than so many samples.
    struct Full(usize);

    impl RunSink for Full {
        fn frame(&mut self, _: &Snapshot, _: &Surface, _: &Conservation) -> Result<(), SinkError> {
            Ok(())
        }

        fn sample(&mut self, _: f64, _: &[Reading], _: &Conservation) -> Result<(), SinkError> {
            if self.0 == 0 {
                return Err(SinkError::new("probes.csv", "full"));
            }
            self.0 -= 1;
            Ok(())
        }

        fn tick(&mut self) -> Result<(), SinkError> {
            Ok(())
        }

        fn checkpoint(&mut self, _: State) -> Result<(), SinkError> {
            Ok(())
        }

        fn wreck(&mut self, _: &Snapshot) -> Result<(), SinkError> {
            Ok(())
        }

        fn finish(&mut self, _: &Outcome) -> Result<(), SinkError> {
            Err(SinkError::new("summary.json", "full"))
        }
    }

    #[test]
    fn what_can_not_be_written_is_told_sooner_or_later() {
        let mut sink = WriterThread::new(Path::new("out"), Box::new(Full(3))).unwrap();
        let mut sample = || sink.sample(0.0, &[], &Conservation::default());
        let trouble = (0..100_000).find_map(|_| sample().err()).expect("a full disk");
        assert_eq!((trouble.path.to_str(), &*trouble.message), (Some("probes.csv"), "full"));
    }
}
