use super::super::marks::Mark;
use super::*;

const FINGERPRINT: &str = "one run";

/// Journals of a run in a folder of its own.
struct Table {
    folder: tempfile::TempDir,
}

impl Table {
    fn new() -> Self {
        Self {
            folder: tempfile::TempDir::new().unwrap(),
        }
    }

    fn output(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    fn worker(&self, number: usize, count: usize) -> WorkersJournal {
        let worker = Worker { number, count };
        let plain = self.folder.path().join("out.partial");
        WorkersJournal::of_worker(&self.output(), &plain, FINGERPRINT, worker).unwrap()
    }

    fn joined(&self) -> Result<WorkersJournal, StoreError> {
        let path = self.folder.path().join("out.partial");
        let own = Journal::open(&path, FINGERPRINT, false).unwrap();
        WorkersJournal::joining(own, &self.output(), FINGERPRINT, &|_| ())
    }

    /// The journal of a worker whose life began on another machine.
    fn elsewhere(&self, number: usize, marks: &[Mark]) {
        let folder = WorkersJournal::folder(&self.output());
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join(format!("{number}-of-9.journal"));
        let journal = Journal::open(&path, FINGERPRINT, false).unwrap();
        let mut life = Life::begins(Some(Worker { number, count: 9 }));
        life.kernel = "another".to_owned();
        put_mark(&journal, &Mark::Life(life)).unwrap();
        for mark in marks {
            put_mark(&journal, mark).unwrap();
        }
    }
}

fn keys(count: usize) -> Vec<String> {
    (0..count).map(|i| format!("task {i}")).collect()
}

#[test]
fn own_tasks_come_first_and_those_of_others_from_their_end() {
    let worker = |number| Worker { number, count: 3 };
    assert_eq!(order(7, Some(worker(1))), [0, 3, 6, 4, 1, 5, 2]);
    assert_eq!(order(7, Some(worker(3))), [2, 5, 6, 3, 0, 4, 1]);
    assert_eq!(order(2, Some(worker(3))), [0, 1], "more workers than tasks");
    assert_eq!(order(3, None), [0, 1, 2]);
}

#[test]
fn two_workers_share_a_round() {
    let table = Table::new();
    let [one, two] = [1, 2].map(|number| table.worker(number, 2));
    let keys = keys(4);
    let rounds = [&one, &two].map(|worker| worker.begin(Phase::Connect, &keys));
    let next = |k: usize| rounds[k].next().unwrap();
    assert_eq!((next(0), next(1)), (Some(0), Some(1)));
    one.put("task 0", b"zero").unwrap();
    assert_eq!(next(0), Some(2));
    one.put("task 2", b"two").unwrap();
    // It takes over the other's last task, and the other sees this.
    assert_eq!(next(0), Some(3));
    two.put("task 1", b"one").unwrap();
    // Journals are not read again at once.
    std::thread::sleep(Duration::from_millis(300));
    let waiting = std::thread::scope(|scope| {
        let waiting = scope.spawn(|| rounds[1].next().unwrap());
        std::thread::sleep(Duration::from_millis(200));
        assert!(!waiting.is_finished(), "the last task is not done yet");
        one.put("task 3", b"three").unwrap();
        waiting.join().unwrap()
    });
    assert_eq!(waiting, None);
    assert_eq!(rounds[1].finished(), 4);
    assert_eq!(two.get("task 3").unwrap().unwrap(), b"three");
    assert_eq!(
        rounds[0].next().unwrap(),
        None,
        "it reads what the other did"
    );
    drop(rounds);
    assert_eq!(one.len(), 4);
    assert!(matches!(
        table.joined(),
        Err(StoreError::WorkerAtWork { .. })
    ));
    one.end().unwrap();
    two.end().unwrap();
    let joined = table.joined().unwrap();
    assert_eq!(joined.len(), 4);
    assert_eq!(joined.get("task 1").unwrap().unwrap(), b"one");
    joined.remove().unwrap();
    assert_eq!(std::fs::read_dir(table.folder.path()).unwrap().count(), 0);
}

#[test]
fn tasks_of_a_worker_that_is_gone_are_free() {
    let table = Table::new();
    let keys = keys(2);
    let begun = |number: usize| {
        let worker = table.worker(number, 2);
        worker.begin(Phase::Connect, &keys).next().unwrap()
    };
    // It begins its task and ends without a mark, as when it is killed.
    assert_eq!(begun(1), Some(0));
    let two = table.worker(2, 2);
    let round = two.begin(Phase::Connect, &keys);
    assert_eq!(round.next().unwrap(), Some(1));
    assert_eq!(round.next().unwrap(), Some(0));
}

#[test]
fn a_worker_on_another_machine_is_known_by_its_growing_journal() {
    let table = Table::new();
    let key = keys(1).remove(0);
    let begin = Mark::Begin {
        key: key.clone(),
        round: 0,
    };
    table.elsewhere(3, std::slice::from_ref(&begin));
    let worker = table.worker(1, 9);
    assert!(matches!(worker.standing(&key), Standing::AtWork));
    // It has not grown for long.
    for tail in &mut worker.others().tails {
        tail.age(PATIENCE);
    }
    assert!(matches!(worker.standing(&key), Standing::Free));
    // It grows again.
    table.elsewhere(3, &[begin.clone(), Mark::Alive(now())]);
    worker.refresh(Duration::ZERO).unwrap();
    assert!(matches!(worker.standing(&key), Standing::AtWork));
    // It has started again, so nobody works at what it had begun before; then it ends.
    table.elsewhere(3, &[]);
    worker.refresh(Duration::ZERO).unwrap();
    assert!(matches!(worker.standing(&key), Standing::Free));
    table.elsewhere(3, &[begin, Mark::End]);
    worker.refresh(Duration::ZERO).unwrap();
    assert!(matches!(worker.standing(&key), Standing::Free));
    worker.end().unwrap();
    assert_eq!(table.joined().unwrap().journals_of_others(), 2);
}

#[test]
fn other_builds_are_told_and_other_processors_are_not() {
    let table = Table::new();
    let folder = WorkersJournal::folder(&table.output());
    std::fs::create_dir_all(&folder).unwrap();
    let journal = Journal::open(&folder.join("2-of-9.journal"), FINGERPRINT, false).unwrap();
    let mut life = Life::begins(Some(Worker {
        number: 2,
        count: 9,
    }));
    life.machine.instructions = vec!["mmx".to_owned()];
    put_mark(&journal, &Mark::Life(life.clone())).unwrap();
    assert_eq!(table.worker(1, 9).other_builds(), []);
    life.machine.program = "0.0.9 (7 bytes)".to_owned();
    put_mark(&journal, &Mark::Life(life)).unwrap();
    let worker = table.worker(1, 9);
    let [(other, difference)] = &worker.other_builds()[..] else {
        panic!("one differs");
    };
    assert_eq!(other.number, 2);
    assert!(difference.starts_with("0.0.9 (7 bytes), "), "{difference}");
}
