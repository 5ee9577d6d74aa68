#include "tools/sampling/sample_bundle.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/files.h"
#include "common/output_file.h"
#include "common/status_macros.h"
#include "deploy/bundle/bundle.h"
#include "sim/motion/library.h"
#include "sim/world/task_check.h"
#include "tools/evaluation/bundle_subject.h"
#include "tools/sampling/library_transitions.h"
#include "tools/sampling/sample_starts.h"
#include "tools/sampling/sampler.h"
#include "tools/sampling/sampling_json.h"
#include "tools/sampling/shown_samples.h"

namespace sinew::sampling {
namespace {

// Samples of each way in pictures and page.
constexpr int kShown = 6;
constexpr int kUsualPerStart = 4;

absl::Status Refuse(absl::string_view flag, absl::string_view expected,
                    double found) {
  return absl::InvalidArgumentError(
      absl::StrFormat("--%s: expected %s, found %g", flag, expected, found));
}

// The shortest text that is this scale and no other: ways go by their names.
std::string NoiseName(double scale) {
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), scale).ptr;
  return absl::StrCat("noise ", std::string(text.data(), end));
}

absl::Status CheckOptions(const SamplingOptions& options) {
  if (!(options.seconds > 0) || !std::isfinite(options.seconds)) {
    return Refuse("seconds", "> 0", options.seconds);
  }
  if (options.count < 1) return Refuse("count", ">= 1", options.count);
  if (options.per_start < 0 ||
      (options.per_start > 0 && options.count % options.per_start != 0)) {
    return Refuse("per-start",
                  absl::StrCat("a divisor of --count ", options.count),
                  options.per_start);
  }
  for (const double noise : options.noise) {
    if (!(noise >= 0 && noise <= kMostNoise)) {
      return Refuse("noise", absl::StrCat("0 to ", kMostNoise), noise);
    }
  }
  if (options.threads < 1) return Refuse("threads", ">= 1", options.threads);
  if (!(options.threshold > 0) || !std::isfinite(options.threshold)) {
    return Refuse("threshold", "> 0", options.threshold);
  }
  if (options.transitions < 1) {
    return Refuse("transitions", ">= 1",
                  static_cast<double>(options.transitions));
  }
  if (!options.out.empty() && options.out == options.page) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--page: expected another file than --out, found ", options.page));
  }
  if (options.student && options.motions.empty()) {
    return absl::InvalidArgumentError(
        "--student: expected --motions, the clips to be tracked");
  }
  return absl::OkStatus();
}

// One call of SampleBundle.
class Sampling {
 public:
  Sampling(const SamplingOptions& options, const StopToken& stop)
      : options_(options), stop_(stop) {}

  absl::StatusOr<SamplingResult> Run() {
    SINEW_RETURN_IF_ERROR(CheckOptions(options_));
    for (const std::string& path : {options_.out, options_.page}) {
      if (!path.empty()) SINEW_RETURN_IF_ERROR(CheckOutputFile(path));
    }
    SINEW_RETURN_IF_ERROR(Load());
    SINEW_RETURN_IF_ERROR(MakeOrder());
    if (library_ != nullptr) SINEW_RETURN_IF_ERROR(Compare());
    SINEW_RETURN_IF_ERROR(AddWay("zero action", std::nullopt));
    SINEW_RETURN_IF_ERROR(AddWay("zero noise", 0));
    std::vector<double> noise = options_.noise;
    std::sort(noise.begin(), noise.end());
    noise.erase(std::unique(noise.begin(), noise.end()), noise.end());
    for (const double scale : noise) {
      if (scale == 0) continue;  // is there
      SINEW_RETURN_IF_ERROR(AddWay(NoiseName(scale), scale));
    }
    SINEW_RETURN_IF_ERROR(Write());
    return std::move(result_);
  }

 private:
  absl::Status Load() {
    SINEW_ASSIGN_OR_RETURN(const bundle::Bundle bundle,
                           bundle::ReadBundle(options_.bundle));
    SINEW_ASSIGN_OR_RETURN(sampler_, Sampler::Create(bundle));
    manifest_sha256_ = bundle.manifest.manifest_sha256();
    if (options_.motions.empty()) return absl::OkStatus();
    SINEW_ASSIGN_OR_RETURN(library_, motion::Library::Load(options_.motions));
    SINEW_RETURN_IF_ERROR(library_->Verify());
    const absl::Status fits = world::CheckTask(
        sampler_->law().recipe(), sampler_->law().character(), *library_);
    if (fits.ok()) return fits;
    return absl::Status(fits.code(),
                        absl::StrCat(options_.motions, ": does not fit bundle ",
                                     options_.bundle, ": ", fits.message()));
  }

  absl::Status MakeOrder() {
    start_ = options_.start;
    if (start_.empty()) start_ = library_ == nullptr ? "fallen" : "clip";
    SINEW_ASSIGN_OR_RETURN(const StartKind kind, ParseStart(start_));
    if (kind.kind == StartKind::Kind::kGiven && options_.per_start > 0) {
      return Refuse("per-start", "none with one start for all samples",
                    options_.per_start);
    }
    per_start_ = options_.per_start > 0
                     ? options_.per_start
                     : std::gcd(options_.count, kUsualPerStart);
    if (kind.kind == StartKind::Kind::kGiven) per_start_ = options_.count;
    const double steps =
        std::max(1.0, std::round(options_.seconds * law().control_hz()));
    if (steps * options_.count > static_cast<double>(kMostSteps)) {
      return Refuse(
          "count",
          absl::StrCat("at most ", kMostSteps, " control steps of all samples"),
          steps * options_.count);
    }
    steps_ = static_cast<int>(steps);
    SINEW_ASSIGN_OR_RETURN(
        starts_, MakeStarts(law(), library_.get(), kind,
                            options_.count / per_start_, options_.seed, stop_));
    return absl::OkStatus();
  }

  absl::Status Compare() {
    SINEW_ASSIGN_OR_RETURN(transitions_,
                           MakeLibraryTransitions(*sampler_, *library_,
                                                  options_.transitions, stop_));
    if (!options_.student) return absl::OkStatus();
    SINEW_ASSIGN_OR_RETURN(
        const evaluation::BundleSubject student,
        evaluation::LoadBundleSubject(options_.bundle, options_.motions));
    return AddStudent(*sampler_, student.subject, options_.seconds,
                      options_.transitions, options_.threads, stop_,
                      &*transitions_);
  }

  absl::Status AddWay(const std::string& name, std::optional<double> noise) {
    const bool draws = noise.has_value() && *noise > 0;
    const bool shows = !options_.pictures.empty() || !options_.page.empty();
    SINEW_ASSIGN_OR_RETURN(
        const std::vector<SampleMotion> motions,
        sampler_->Run({.starts = starts_,
                       // What draws nothing does the same each time.
                       .per_start = draws ? per_start_ : 1,
                       .steps = steps_,
                       .noise = noise,
                       .seed = options_.seed,
                       .threads = options_.threads,
                       .keep_qpos = shows ? kShown : 0},
                      stop_));
    SINEW_ASSIGN_OR_RETURN(
        SampleFigures figures,
        MeasureSamples(*sampler_, starts_, motions,
                       transitions_ ? &*transitions_ : nullptr,
                       {.threshold = options_.threshold,
                        .most_transitions = options_.transitions,
                        .threads = options_.threads},
                       stop_));
    figures.name = name;
    figures.noise = noise;
    ShownWay way = {.name = name, .samples = {}};
    for (size_t i = 0; i < motions.size() && !motions[i].qpos.empty(); ++i) {
      way.samples.push_back(
          {.start = figures.rows[i].start, .qpos = motions[i].qpos});
    }
    shown_.push_back(std::move(way));
    result_.ways.push_back(std::move(figures));
    return absl::OkStatus();
  }

  SamplingSource Source() const {
    const mjModel* model = law().character().model();
    return {.bundle = options_.bundle,
            .manifest_sha256 = manifest_sha256_,
            .character = law().character().name(),
            .motions = options_.motions,
            .library_sha256 = library_ == nullptr ? "" : library_->digest(),
            .start = start_,
            .seconds = steps_ / law().control_hz(),
            .seed = options_.seed,
            .control_hz = law().control_hz(),
            .upright_body = mj_id2name(model, mjOBJ_BODY, law().upright_body()),
            .standing_height = law().standing_height(),
            .features = sampler_->num_features(),
            .threshold = options_.threshold,
            .student_randomised =
                law().recipe().task().randomisation().in_evaluation()};
  }

  absl::Status Write() {
    const SamplingSource source = Source();
    if (!options_.out.empty()) {
      SINEW_RETURN_IF_ERROR(WriteFileAtomically(
          options_.out,
          SamplingJson(source, transitions_ ? &*transitions_ : nullptr,
                       result_.ways)));
      result_.files.push_back(options_.out);
    }
    if (!options_.page.empty()) {
      SINEW_ASSIGN_OR_RETURN(
          const std::string page,
          SamplesPage(law().character(), source, result_.ways, shown_));
      SINEW_RETURN_IF_ERROR(WriteFileAtomically(options_.page, page));
      result_.files.push_back(options_.page);
    }
    if (options_.pictures.empty()) return absl::OkStatus();
    SINEW_ASSIGN_OR_RETURN(const std::vector<std::string> pictures,
                           WritePictures(law().character(), law().control_hz(),
                                         shown_, options_.pictures, stop_));
    result_.files.insert(result_.files.end(), pictures.begin(), pictures.end());
    return absl::OkStatus();
  }

  const BodyLaw& law() const { return sampler_->law(); }

  const SamplingOptions& options_;
  const StopToken stop_;
  std::string manifest_sha256_;  // of the bundle
  std::unique_ptr<const Sampler> sampler_;
  std::unique_ptr<const motion::Library> library_;  // may be null
  std::optional<LibraryTransitions> transitions_;
  std::string start_;
  std::vector<SampleStart> starts_;
  int per_start_ = 1;
  int steps_ = 1;
  std::vector<ShownWay> shown_;
  SamplingResult result_;
};

}  // namespace

absl::StatusOr<SamplingResult> SampleBundle(const SamplingOptions& options,
                                            const StopToken& stop) {
  return Sampling(options, stop).Run();
}

}  // namespace sinew::sampling
