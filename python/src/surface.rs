//! Surfaces given by a Python function: searched, mapped and descended on.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use landscape::cli::Watch;
use landscape::energy::{Counted, Energy, InBox, check_gradient};
use landscape::optimize::{StopReason, quench as descend};
use landscape::space::Space;
use landscape::store::{AtomicFolder, Source, content_hash};
use landscape::study::{
    Coordinates, MapSearch, StudyRun, Subject, SurfaceMapReport, SurfaceReport, SurfaceSearch,
    broken_symmetry, difference_step, gradient_points, in_region, map_surface, onto,
    search_surface,
};
use landscape::topography::{
    FamilySettings, GuardedJournal, LowestSettings, Run, Scales, SearchSettings, probe_size,
};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use crate::arrays::{column, points, table};
use crate::callable::{Asked, Function};
use crate::error::{Failure, input};
use crate::work::{attached, detached};

/// A function on a space with a region, and how it is asked.
#[pyclass(frozen, module = "landscape._native")]
#[derive(Debug)]
pub(crate) struct Surface {
    parts: Arc<Parts>,
}

struct Parts {
    name: String,
    kind: Coordinates,
    low: Vec<f64>,
    high: Vec<f64>,
    asked: Asked,
    space: Box<dyn Space + Send>,
    threads: usize,
}

impl std::fmt::Debug for Parts {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut shown = formatter.debug_struct("Parts");
        shown.field("name", &self.name).finish_non_exhaustive()
    }
}

/// What a search does beside asking the function.
#[derive(Debug, FromPyObject)]
pub(crate) struct Search {
    #[pyo3(item)]
    out: PathBuf,
    #[pyo3(item)]
    command: String,
    #[pyo3(item)]
    seed: u64,
    #[pyo3(item)]
    check_gradient: bool,
    #[pyo3(item)]
    quiet: bool,
    #[pyo3(item)]
    patience: Option<usize>,
    #[pyo3(item)]
    searches: Option<usize>,
    #[pyo3(item)]
    search: String,
    #[pyo3(item)]
    lowest: Option<usize>,
    #[pyo3(item)]
    budget_s: Option<f64>,
    #[pyo3(item)]
    family_barrier: Option<f64>,
    #[pyo3(item)]
    neighbours: Option<usize>,
}

impl Parts {
    fn region(&self) -> (&[f64], &[f64]) {
        (&self.low, &self.high)
    }

    fn function(&self) -> Function<'_> {
        Function {
            asked: &self.asked,
            space: &*self.space,
            difference: difference_step(self.region()),
        }
    }

    /// The subject of a report, without a function that is asked.
    fn subject<'a>(&'a self, energy: &'a dyn Energy) -> Subject<'a> {
        Subject {
            name: &self.name,
            energy,
            coordinates: self.kind.name(),
            low: self.low.clone(),
            high: self.high.clone(),
            source: Source {
                name: self.name.clone(),
                content_hash: content_hash(&[self.name.as_bytes()]),
            },
        }
    }

    /// Compares the gradient with differences of the energy, and the caller's Hessian with differences of the gradient.
    fn check(
        &self,
        energy: &dyn Energy,
        region: (&[f64], &[f64]),
        seed: u64,
    ) -> Result<(), Failure> {
        let step = difference_step(self.region());
        let proceed = || self.asked.check().map(|()| true);
        let points = gradient_points(energy, region, step, seed, proceed)?;
        let checked = check_gradient(energy, &points, step);
        self.asked.check()?;
        checked.map_err(|fault| Failure::Gradient(Box::new(fault)))?;
        if let Coordinates::Symmetric { generators, .. } = &self.kind
            && let Some(broken) =
                broken_symmetry(generators, energy, &points, || self.asked.check())?
        {
            return Err(Failure::Input(format!("symmetries: {broken}")));
        }
        if self.kind == Coordinates::Box {
            // Searches in a box ask for gradients only.
            return Ok(());
        }
        let sides = self
            .low
            .iter()
            .zip(&self.high)
            .map(|(low, high)| high - low);
        let side = sides.fold(f64::INFINITY, f64::min);
        self.asked.check_hessian(energy, &points, (step, side))?;
        self.asked.check()
    }

    /// The function in its box, if it has one that bounds it.
    fn in_box(&self) -> Option<InBox<impl Fn(&[f64], &mut [f64]) -> f64 + Sync>> {
        (self.kind == Coordinates::Box).then(|| {
            InBox::new(&self.low, &self.high, |x, gradient| {
                self.asked.evaluate(x, gradient)
            })
        })
    }

    fn folder(search: &Search) -> Result<AtomicFolder, Failure> {
        AtomicFolder::open(&search.out, true).map_err(|error| Failure::of(&error))
    }

    fn explore(&self, mut known: Vec<Vec<f64>>, search: &Search) -> Result<String, Failure> {
        let function = self.function();
        let boxed = self.in_box();
        let energy: &dyn Energy = match &boxed {
            Some(boxed) => boxed,
            None => function.energy(),
        };
        let (low, high) = match &boxed {
            Some(boxed) => boxed.region(),
            None => (self.low.clone(), self.high.clone()),
        };
        if let Some(boxed) = &boxed {
            for point in &mut known {
                *point = boxed.coordinates(point);
            }
        }
        let started = Instant::now();
        let budget = search.budget_s.map(Duration::from_secs_f64);
        let enough =
            |share: f64| budget.is_some_and(|budget| started.elapsed() >= budget.mul_f64(share));
        if search.check_gradient {
            self.check(energy, (&low, &high), search.seed)?;
        }
        let draw = in_region(energy.space(), (&low, &high));
        let counted = Counted::new(energy);
        let mut settings = SearchSettings::measured(&counted, &draw, search.seed);
        self.asked.check()?;
        settings.patience = search.patience.unwrap_or(settings.patience);
        settings.max_searches = search.searches.unwrap_or(settings.max_searches);
        let mut probed = 0;
        let wanted = match search.search.as_str() {
            "all" => false,
            "lowest" => true,
            _ => {
                let probe = probe_size(energy, &draw, &settings, &enough);
                probed = probe.evaluations as u64;
                probe.is_too_large(&settings)
            }
        };
        self.asked.check()?;
        // The usual limit has decided what is searched for.
        if search.budget_s.is_some() && search.searches.is_none() {
            settings.max_searches = SearchSettings::NO_LIMIT;
        }
        let usual = LowestSettings::default();
        let lowest = wanted.then(|| LowestSettings {
            minima: search.lowest.unwrap_or(usual.minima),
            ..usual
        });
        let folder = Self::folder(search)?;
        let watch = Watch::new(search.quiet);
        let guard = || self.asked.check_journal();
        let run = StudyRun {
            run: Run {
                journal: &GuardedJournal {
                    journal: Run::default().journal,
                    check: &guard,
                },
                observer: &|news| watch.see(news),
                enough: &enough,
            },
            stage_ended: &|_, _| (),
        };
        let shown = self.subject(function.energy());
        let mut subject = shown.clone();
        subject.energy = energy;
        (subject.low, subject.high) = (low.clone(), high.clone());
        let families = FamilySettings {
            barrier: search.family_barrier,
            ..FamilySettings::default()
        };
        let how = SurfaceSearch {
            settings: &settings,
            lowest: lowest.as_ref(),
            known: &known,
            pair: None,
        };
        let searched = search_surface(&subject, &how, &families, &run);
        watch.clear();
        self.asked.check()?;
        let mut searched = searched?;
        if let Some(boxed) = &boxed {
            searched.shown_as(&|u| boxed.point(u), &shown, &settings);
            self.asked.check()?;
        }
        let report = SurfaceReport {
            subject: &shown,
            found: &searched.found,
            landscape: &searched.landscape,
            settings: &settings,
            lowest: searched.lowest.as_ref(),
            command: search.command.clone(),
            measuring: counted.evaluations() + probed,
        };
        let text = report.write(&folder)?.text;
        self.finish(folder)?;
        Ok(text)
    }

    fn map(&self, starts: &[Vec<f64>], search: &Search) -> Result<String, Failure> {
        let function = self.function();
        let energy = function.energy();
        if self.kind == Coordinates::Box {
            return Err(Failure::Input(
                "space Box(): a map in a box is not made; `explore` searches there".to_owned(),
            ));
        }
        if search.check_gradient {
            self.check(energy, self.region(), search.seed)?;
        }
        let folder = Self::folder(search)?;
        let watch = Watch::new(search.quiet);
        let guard = || self.asked.check_journal();
        let run = StudyRun {
            run: Run {
                journal: &GuardedJournal {
                    journal: Run::default().journal,
                    check: &guard,
                },
                observer: &|news| watch.see(news),
                ..Run::default()
            },
            stage_ended: &|_, _| (),
        };
        let found = map_surface(
            &self.name,
            energy,
            starts,
            if search.search == "adelm" {
                MapSearch::Adelm
            } else {
                MapSearch::Passes
            },
            |settings| {
                settings.seed = search.seed;
                settings.neighbours = search.neighbours.unwrap_or(settings.neighbours);
                settings.families.barrier = search.family_barrier;
            },
            &run,
        );
        watch.clear();
        self.asked.check()?;
        let found = found?;
        let report = SurfaceMapReport {
            subject: &self.subject(energy),
            found: &found,
            command: search.command.clone(),
        };
        let text = report.write(&folder)?.text;
        self.finish(folder)?;
        Ok(text)
    }

    /// Gives the folder its name, unless the function failed while the report asked it.
    fn finish(&self, folder: AtomicFolder) -> Result<(), Failure> {
        self.asked.check()?;
        folder.finish().map_err(|error| Failure::of(&error))?;
        Ok(())
    }
}

/// Points, energies, norms of gradients, evaluations, and whether the descent converged, row by row.
type Descents<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<u64>>,
    Bound<'py, PyArray1<bool>>,
);

#[pymethods]
impl Surface {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "the façade names them")]
    fn new(
        py: Python<'_>,
        function: Py<PyAny>,
        hessian: Option<Py<PyAny>>,
        batch: bool,
        name: String,
        kind: &str,
        low: Vec<f64>,
        high: Vec<f64>,
        threads: usize,
    ) -> PyResult<Self> {
        let Some(kind) = Coordinates::named(kind) else {
            return Err(input(py, format!("no coordinates are called `{kind}`")));
        };
        let region = low.iter().zip(&high);
        if low.len() != high.len()
            || low.is_empty()
            || !region
                .clone()
                .all(|(low, high)| low < high && (high - low).is_finite())
        {
            return Err(input(
                py,
                format!("box: {low:?} to {high:?} is not a box with low < high in each coordinate"),
            ));
        }
        let space = kind.space((&low, &high)).map_err(|wrong| match kind {
            Coordinates::Symmetric { .. } => input(py, format!("symmetries: {wrong}")),
            _ => input(py, format!("the space has {wrong}")),
        })?;
        if matches!(kind, Coordinates::Atoms | Coordinates::Elements(_)) && low.len() < 6 {
            return Err(input(py, "Atoms(1): one atom has no shape; two are needed"));
        }
        let asked = Asked::new(function, hessian, batch, &*space);
        Ok(Self {
            parts: Arc::new(Parts {
                name,
                kind,
                low,
                high,
                asked,
                space,
                threads,
            }),
        })
    }

    /// Searches for all minima and saddles, writes the folder of the landscape, and returns its summary.
    fn explore(
        &self,
        py: Python<'_>,
        known: &Bound<'_, PyAny>,
        search: Search,
    ) -> PyResult<String> {
        let known = self.points(py, "known", known)?;
        self.work(py, move |parts| parts.explore(known, &search))
    }

    /// Maps the landscape between the minima below `starts`, writes its folder, and returns its summary.
    fn map(&self, py: Python<'_>, starts: &Bound<'_, PyAny>, search: Search) -> PyResult<String> {
        let starts = self.points(py, "minima", starts)?;
        self.work(py, move |parts| parts.map(&starts, &search))
    }

    /// Descends from each point.
    #[pyo3(signature = (starts, gradient_tolerance, check_gradient=true))]
    fn quench<'py>(
        &self,
        py: Python<'py>,
        starts: &Bound<'py, PyAny>,
        gradient_tolerance: Option<f64>,
        check_gradient: bool,
    ) -> PyResult<Descents<'py>> {
        let mut starts = self.points(py, "starts", starts)?;
        let size = self.parts.low.len();
        let found = self.work(py, move |parts| {
            let function = parts.function();
            let boxed = parts.in_box();
            let mut region = (parts.low.clone(), parts.high.clone());
            let mut energy = function.energy();
            if let Some(boxed) = &boxed {
                (energy, region) = (boxed, boxed.region());
                for point in &mut starts {
                    *point = boxed.coordinates(point);
                }
            }
            if check_gradient {
                parts.check(energy, (&region.0, &region.1), 0)?;
            }
            let mut settings = Scales::measured(energy, &starts).quench();
            parts.asked.check()?;
            if let Some(tolerance) = gradient_tolerance {
                settings = settings.with_gradient_tolerance(tolerance);
            }
            let mut found: Vec<_> = (starts.par_iter())
                .map(|x| descend(energy, x, &settings))
                .collect();
            if let Some(boxed) = &boxed {
                for end in &mut found {
                    end.x = boxed.point(&end.x);
                }
            }
            parts.asked.check()?;
            Ok(found)
        })?;
        let flat = found.iter().flat_map(|end| end.x.iter().copied());
        Ok((
            table(py, flat.collect(), size)?,
            column(py, found.iter().map(|end| end.energy).collect()),
            column(py, found.iter().map(|end| end.gradient_norm).collect()),
            column(py, found.iter().map(|end| end.evaluations as u64).collect()),
            column(
                py,
                found
                    .iter()
                    .map(|end| end.stop == StopReason::Converged)
                    .collect(),
            ),
        ))
    }

    /// Energies and gradients at each point, as a search gets them.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        given: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>)> {
        let given = self.points(py, "points", given)?;
        let tangents = self.parts.space.tangents();
        let (energies, gradients) = self.work(py, move |parts| {
            let mut gradients = vec![0.0; given.len() * tangents];
            let mut energies = vec![0.0; given.len()];
            parts
                .asked
                .evaluate_all(&given, &mut energies, &mut gradients);
            parts.asked.check()?;
            Ok((energies, gradients))
        })?;
        Ok((column(py, energies), table(py, gradients, tangents)?))
    }
}

impl Surface {
    /// Points of the space that the caller gave.
    fn points(
        &self,
        py: Python<'_>,
        name: &str,
        given: &Bound<'_, PyAny>,
    ) -> PyResult<Vec<Vec<f64>>> {
        let mut rows = points(py, name, given, self.parts.low.len())?;
        for (row, x) in rows.iter_mut().enumerate() {
            let inside = || {
                (x.iter().zip(&self.parts.low).zip(&self.parts.high))
                    .all(|((x, low), high)| low <= x && x <= high)
            };
            if self.parts.kind == Coordinates::Box && !inside() {
                return Err(input(py, format!("{name}: row {row} is outside the box")));
            }
            onto(&*self.parts.space, x);
            if x.iter().any(|number| !number.is_finite()) {
                return Err(input(py, format!("{name}: row {row} is not a quaternion")));
            }
        }
        Ok(rows)
    }

    /// Runs work on as many threads as the function may be asked from.
    fn work<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Parts) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        let parts = self.parts.clone();
        let stopping = self.parts.clone();
        let threads = parts.threads;
        detached(
            py,
            move || stopping.asked.stop(),
            move || {
                ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build_scoped(attached, |pool| pool.install(|| work(&parts)))
                    .unwrap_or_else(|error| Err(Failure::of(&error)))
            },
        )
    }
}
