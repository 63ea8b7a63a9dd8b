//! Runs an inference: ensembles of a plate at points of its parameters, a likelihood fitted to them, the posterior, and plates
//! predicted by it.
//!
//! Ensembles are those of the plate's own scene. They do not depend on the measured plates: a finished run in a folder serves
//! other data, summaries, priors and samplers with `--resume`.

mod answers;
mod ensembles;
mod findings;
mod pictures;
mod posterior_record;
mod predictive;
mod record;

use crack_inference::{
    Emulator, EmulatorMixture, Error, Observations, ParameterSpace, Posterior, SamplerConfig,
    Summaries,
};
use result_figures::Drawing;
use scene_runs::answers::Number;
use scene_runs::clock::CpuClock;
use scene_runs::kind::{Completed, EnsemblePart, Inputs, Output, Run, RunError, SceneKind};
use scene_runs::result_file::ResultFile;
use scene_runs::scene::{Objection, SceneFile};
use sde_integrators::Noise;

use self::ensembles::{Ended, Ensembles, Series};
use self::posterior_record::{correlations, parameters};
use self::predictive::{Predicted, share};
use self::record::{
    Content, EmulatorRecord, MeasuredRecord, PredictiveRecord, SamplerRecord, WorkRecord,
};
use super::measured::{Measured, SummaryError, errors, summaries};
use super::plate::{PlateError, PlateModel};
use super::scene::{DesignScene, InferenceScene, LoadScene};

/// The value of `solver`.
const SOLVER: &str = "peridyn-sde-inference";

/// Its line in a table of kinds.
pub const KIND: SceneKind = SceneKind {
    solver: SOLVER,
    schema: || schemars::schema_for!(InferenceScene),
    check: |file| file.parse::<InferenceScene>().map(drop),
    run,
    ladder: |file| {
        let _: InferenceScene = file.parse()?;
        Err(RunError::NoLadder {
            solver: SOLVER,
            reason: "the errors of a posterior are those of its model; `advise` takes the scene of the plate",
        })
    },
    ingredients: |_| Vec::new(),
};

/// Keys that do not affect the ensembles of the design: what is inferred from them, and how many of them there are.
const ASIDE: [&str; 13] = [
    "/title",
    "/measured",
    "/summaries",
    "/design/points",
    "/design/emulators",
    "/sampler",
    "/predictive",
    "/parameters/0/prior",
    "/parameters/1/prior",
    "/parameters/2/prior",
    "/parameters/3/prior",
    "/parameters/4/prior",
    "/parameters/5/prior",
];

/// What has random numbers of its own: the seed of the scene plus this.
const EMULATORS: u64 = 1;
const SAMPLER: u64 = 2;
const PREDICTION: u64 = 3;

/// An ensemble of the design to which nothing can be fitted.
#[derive(Debug, thiserror::Error)]
#[error("the ensemble at {point} cannot be used")]
struct Unusable {
    point: String,
    source: SummaryError,
}

fn unusable(point: String, source: SummaryError) -> RunError {
    RunError::solver(Unusable { point, source })
}

impl From<SummaryError> for RunError {
    fn from(error: SummaryError) -> Self {
        Self::solver(error)
    }
}

fn run(file: &SceneFile, run: &Run<'_>) -> Result<Completed, RunError> {
    if *run.part() != EnsemblePart::Whole {
        return Err(RunError::NoShards);
    }
    let (scene, space) = run.build::<InferenceScene>(file)?;
    let refused = |objection: Objection| RunError::from(file.object_to(&objection));
    let plate = PlateModel::read(&scene, file.folder()).map_err(|error| match error {
        PlateError::Here(objection) => refused(objection),
        PlateError::There(error) => error.into(),
    })?;
    let size = plate.scene.body.size;
    let measured = Measured::read(&scene, file.folder(), size).map_err(refused)?;
    let of_plates = measured.summaries(&scene).map_err(refused)?;
    plate.check_corners(&scene).map_err(refused)?;
    // The ensembles do not depend on the measured plates.
    let inputs = Inputs { scene: &scene, seed: Some(scene.seed), files: &plate.files };
    let checkpoint = match run.ranks() {
        Some(_) => None,
        None => Some(run.checkpoint(&inputs, &ASIDE)?),
    };
    let ensembles = Ensembles { file, plate: &plate, checkpoint, progress: run.progress };
    let Some(of_design) = design(&inputs, &space, &ensembles, run)? else {
        return Ok(Completed::Elsewhere(Vec::new()));
    };
    let study = Study { scene: &scene, space: &space, measured: &measured, of_plates: &of_plates };
    let content = study.run(&plate, &ensembles, (&of_design, run))?;
    Ok(Completed::here(run, answers::answers(&content), || study.output(&content)))
}

/// Ensembles at the points of the design; none on ranks without the results.
fn design(
    inputs: &Inputs<'_, InferenceScene>,
    space: &ParameterSpace,
    ensembles: &Ensembles<'_>,
    run: &Run<'_>,
) -> Result<Option<Vec<Ended>>, RunError> {
    let DesignScene { points: n, realisations, .. } = inputs.scene.design;
    run.progress.stage(&format!("{n} ensembles of {realisations} realisations"));
    let points = space.design(whole(n)).map_err(RunError::solver)?;
    let pace = run.pace("ensembles of the design");
    let series = Series { name: "point", seed: inputs.scene.seed, realisations, n, pace };
    let Some(ranks) = run.ranks() else {
        return ensembles.run(&series, &points).map(Some);
    };
    let compute = |block: u64| ensembles.one(&series, (block, &points[whole(block)]));
    let words = |parts: &mut dyn Iterator<Item = &Ended>| {
        parts.last().map_or_else(String::new, |ended| ensembles.plate.words(&ended.point))
    };
    run.on_ranks(ranks, inputs, n, &compute, &words)
}

/// What is inferred from what.
struct Study<'a> {
    scene: &'a InferenceScene,
    space: &'a ParameterSpace,
    measured: &'a Measured,
    of_plates: &'a Summaries,
}

/// A posterior and the likelihood behind it.
struct Inferred {
    emulator: Emulator,
    posterior: Posterior,
    data: Observations,
    summaries: Vec<Summaries>,
}

impl Study<'_> {
    fn run(
        &self,
        plate: &PlateModel,
        ensembles: &Ensembles<'_>,
        (of_design, run): (&[Ended], &Run<'_>),
    ) -> Result<Content, RunError> {
        let scene = self.scene;
        let clock = CpuClock::start();
        run.progress.stage("likelihood and posterior");
        let errors = errors(scene, self.of_plates);
        let inferred = self.infer(plate, of_design, &errors)?;
        let sampled = clock.seconds();

        let realisations = scene.predictive.realisations;
        let draws =
            inferred.posterior.thinned(whole(scene.predictive.draws)).map_err(RunError::solver)?;
        run.progress
            .stage(&format!("{} draws, each with {realisations} realisations", draws.len()));
        let pace = run.pace("ensembles of the prediction");
        let (seed, n) = (self.seed(PREDICTION), draws.len() as u64);
        let series = Series { name: "draw", seed, realisations, n, pace };
        let of_draws = ensembles.run(&series, &draws)?;

        let clock = CpuClock::start();
        let predicted = Predicted {
            ensembles: &of_draws,
            summaries: &scene.summary_config(),
            errors: &errors,
            height_error: scene.measured.height_error,
            seed: self.seed(PREDICTION),
        };
        let summaries = predicted.compare(self.of_plates, &self.names())?;
        let share_inside = share(&summaries).map(Number::from);
        let path = predicted.heights(&plate.abscissae()).map_err(RunError::solver)?;
        let predictive = PredictiveRecord { draws, share_inside, summaries, path };
        let mut content = self.content(plate, &inferred, of_design, predictive)?;
        let of_all = || of_design.iter().chain(&of_draws);
        let of_ensembles: f64 = of_all().map(|ended| ended.seconds).sum();
        content.work = WorkRecord {
            ensembles: of_all().count(),
            realisations: of_all().map(|ended| ended.records.len()).sum(),
            cpu_seconds: of_ensembles + sampled + clock.seconds(),
        };
        Ok(content)
    }

    /// The posterior by the ensembles of the design.
    fn infer(
        &self,
        plate: &PlateModel,
        of_design: &[Ended],
        errors: &[f64],
    ) -> Result<Inferred, RunError> {
        let points: Vec<Vec<f64>> = of_design.iter().map(|ended| ended.point.clone()).collect();
        let summaries = self.summaries(plate, of_design)?;
        let emulator = Emulator::new(self.space, &points, &summaries);
        let emulator = emulator.map_err(|error| match error {
            Error::Ensemble { ensemble, reason } => {
                unusable(plate.words(&points[ensemble]), (*reason).into())
            }
            other => RunError::solver(other),
        })?;
        let noise = Noise::new(self.seed(EMULATORS));
        let n_emulators = whole(self.scene.design.emulators);
        let mixture =
            EmulatorMixture::new(&emulator, n_emulators, &noise).map_err(RunError::solver)?;
        let variances: Vec<f64> = errors.iter().map(|error| error * error).collect();
        let data = Observations::new(self.of_plates, &variances).map_err(RunError::solver)?;
        let likelihood = |point: &[f64]| mixture.value(point, &data);
        let posterior = Posterior::sample(self.space, &likelihood, &self.sampler())
            .map_err(RunError::solver)?;
        Ok(Inferred { emulator, posterior, data, summaries })
    }

    fn content(
        &self,
        plate: &PlateModel,
        inferred: &Inferred,
        of_design: &[Ended],
        predictive: PredictiveRecord,
    ) -> Result<Content, RunError> {
        let Inferred { emulator, posterior, data, summaries } = inferred;
        let of_fit = (&self.names()[..], of_design, &summaries[..]);
        let is_predicted = predictive.summaries.iter().all(|it| !it.is_outside);
        Ok(Content {
            files: plate.files.iter().chain(&self.measured.files).cloned().collect(),
            seed: self.scene.seed,
            work: WorkRecord::default(),
            parameters: parameters(self.space, posterior, emulator, data, is_predicted)?,
            correlations: correlations(self.space, posterior),
            sampler: SamplerRecord {
                acceptance: posterior.acceptance(),
                temperatures: posterior.temperatures().to_vec(),
                has_converged: posterior.has_converged(),
            },
            emulator: EmulatorRecord::new(emulator, posterior, data, of_fit)?,
            measured: MeasuredRecord {
                plates: self.measured.plates.len(),
                without_summaries: self.of_plates.absent().total(),
                paths: self.measured.plates.clone(),
            },
            predictive,
        })
    }

    /// Summaries of the ensembles of the design.
    fn summaries(&self, plate: &PlateModel, of: &[Ended]) -> Result<Vec<Summaries>, RunError> {
        let config = self.scene.summary_config();
        let of_ensemble = |ended: &Ended| {
            summaries(&config, &ended.records)
                .map_err(|source| unusable(plate.words(&ended.point), source))
        };
        of.iter().map(of_ensemble).collect()
    }

    fn seed(&self, purpose: u64) -> u64 {
        self.scene.seed.wrapping_add(purpose)
    }

    fn sampler(&self) -> SamplerConfig {
        let of = &self.scene.sampler;
        SamplerConfig {
            n_particles: whole(of.particles),
            n_moves: whole(of.moves),
            n_chains: whole(of.chains),
            n_warm_up: whole(of.warm_up),
            n_draws: whole(of.draws),
            noise: Noise::new(self.seed(SAMPLER)),
        }
    }

    /// The summaries in words.
    fn names(&self) -> Vec<String> {
        let of = &self.scene.summaries;
        let heights = of.abscissae.iter().map(|x| format!("height at x = {x} m"));
        let load = match of.load {
            LoadScene::None => None,
            LoadScene::FailureLoad => Some("failure load".to_owned()),
            LoadScene::LogFailureLoad => Some("logarithm of the failure load".to_owned()),
        };
        heights.chain(load).collect()
    }

    fn output(&self, content: &Content) -> Result<Output, RunError> {
        let result = ResultFile::new("crack-inference/1", self.scene, content)?;
        let mut report = findings::report(self.scene, content);
        let drawings = report.drawn("charts", self.drawings(content));
        Ok(Output { result, files: Vec::new(), drawings, motions: Vec::new(), report })
    }

    fn drawings(&self, content: &Content) -> Result<Vec<Drawing>, RunError> {
        let title = &self.scene.title;
        let each = (content.predictive.draws.len(), self.scene.predictive.realisations);
        let path = &content.predictive.path;
        let mut drawings = Vec::new();
        drawings.extend(pictures::predictive(title, &self.measured.plates, path, each)?);
        for numbered in (1..).zip(&content.parameters) {
            drawings.push(pictures::marginal(title, numbered)?);
        }
        Ok(drawings)
    }
}

/// A count of a checked scene, at most a million.
fn whole(count: u64) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}
