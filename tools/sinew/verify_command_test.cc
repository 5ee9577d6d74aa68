#include "tools/sinew/verify_command.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/digest.h"
#include "common/files.h"
#include "common/policy/onnx/onnx_writer.h"
#include "common/policy/safetensors.h"
#include "common/stop.h"
#include "common/testing/matchers.h"
#include "deploy/bundle/bundle.h"
#include "deploy/bundle/manifest.h"
#include "deploy/bundle/testing/toy_bundle.h"
#include "deploy/bundle/testing/toy_latent.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "proto/sinew/v1/bundle.pb.h"
#include "sim/world/testing/toy_world.h"
#include "tools/parity/bundle_parity.h"

namespace sinew::tools {
namespace {

using ::sinew::testing::IsOk;
using ::sinew::testing::StatusIs;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

std::string WriteToy() {
  const world::testing::ToyWorld toy = world::testing::MakeToyWorld();
  const std::string directory = JoinPath(toy.folder, "bundle");
  EXPECT_THAT(bundle::WriteBundle(bundle::testing::ToyContent(toy), directory),
              IsOk());
  return directory;
}

absl::Status Verify(const std::string& arguments, std::string* output) {
  CLI::App app;
  app.require_subcommand(1);
  Action action;
  AddVerifyCommand(app, action);
  app.parse("verify " + arguments);
  ::testing::internal::CaptureStdout();
  const absl::Status status = action(StopToken());
  *output = ::testing::internal::GetCapturedStdout();
  return status;
}

TEST(Verify, FindsThatAllBackEndsAgree) {
  std::string output;

  EXPECT_THAT(Verify(WriteToy(), &output), IsOk());

  EXPECT_THAT(output, AllOf(HasSubstr("toy, 4 joints, 68 observations, 30 Hz"),
                            ContainsRegex("action +[0-9.e-]+ +[0-9.e-]+\n"),
                            ContainsRegex("mean +[0-9.e-]+ +[0-9.e-]+\n")));
}

TEST(Verify, ComparesEveryGraphOfALatentBundle) {
  const world::testing::ToyWorld toy =
      world::testing::MakeToyWorld(bundle::testing::ToyLatentRecipe());
  std::string output;

  EXPECT_THAT(Verify(bundle::testing::WriteToyLatent(toy), &output), IsOk())
      << output;

  // Numbers of both back ends stand beside each.
  for (const char* row :
       {"policy +action", "policy +latent", "policy +mean", "encoder +mean",
        "encoder +std", "encoder +log_variance", "prior +mean", "prior +std",
        "decoder +action", "sample +action", "sample +latent"}) {
    EXPECT_THAT(output,
                ContainsRegex(absl::StrCat(row, " +[0-9.e-]+ +[0-9.e-]+\n")));
  }
  EXPECT_THAT(output, HasSubstr("from encoder, prior, decoder: "));
}

TEST(Verify, LeavesOnnxOutIfToldTo) {
  std::string output;

  EXPECT_THAT(Verify(WriteToy() + " --skip-onnx", &output), IsOk());

  EXPECT_THAT(output, ContainsRegex("action +[0-9.e-]+ +skipped\n"));
}

TEST(Verify, RefusesAnAlteredBundle) {
  const std::string directory = WriteToy();
  const std::string path = JoinPath(directory, "policy.onnx");
  std::string model = *ReadFile(path);
  model[model.size() / 2] ^= 4;
  ASSERT_THAT(WriteFileAtomically(path, model), IsOk());
  std::string output;

  EXPECT_THAT(Verify(directory, &output),
              StatusIs(absl::StatusCode::kDataLoss, HasSubstr(path)));
}

// The model of the bundle's policy with two of its parameters mixed up.
std::string EditedModel(const bundle::Bundle& bundle) {
  const std::string weights =
      ReadFile(JoinPath(bundle.directory, bundle::kWeightsFile)).value();
  auto locations = LocateSafetensors(weights, bundle::kWeightsFile).value();
  std::swap(locations.at("policy/mean/bias"), locations.at("policy/std"));
  return policy::WriteOnnx(bundle.graph, "policy", locations,
                           bundle::kWeightsFile)
      .value();
}

TEST(Verify, CatchesAnEditedModelWhoseManifestWasSignedAnew) {
  const std::string directory = WriteToy();
  const auto read = bundle::ReadBundle(directory);
  ASSERT_THAT(read, IsOk());
  const std::string model = EditedModel(*read);
  v1::BundleManifest manifest = read->manifest;
  (*manifest.mutable_files())[bundle::OnnxFile("policy")] = Sha256Hex(model);
  const auto signed_anew = bundle::PrintManifest(manifest);
  ASSERT_THAT(signed_anew, IsOk());
  ASSERT_THAT(WriteFileAtomically(read->onnx_file("policy"), model), IsOk());
  ASSERT_THAT(WriteFileAtomically(JoinPath(directory, bundle::kManifestFile),
                                  *signed_anew),
              IsOk());
  std::string output;

  EXPECT_THAT(Verify(directory, &output),
              StatusIs(absl::StatusCode::kInternal,
                       AllOf(HasSubstr("graph \"policy\": tap \"action\""),
                             HasSubstr("expected onnxruntime within 1e-05 of "
                                       "the executor"))));

  // All digests fit, so nothing else can tell.
  EXPECT_THAT(Verify(directory + " --skip-onnx", &output), IsOk());
}

TEST(Verify, NamesWhatIsNoBundle) {
  std::string output;

  EXPECT_THAT(Verify("/nowhere", &output),
              StatusIs(absl::StatusCode::kNotFound, HasSubstr("/nowhere")));
}

TEST(ParityDifference, IsRelativeToTheLargestValue) {
  EXPECT_DOUBLE_EQ(ParityDifference({4, -8, 0}, {4, -8, 2}), 0.25);
  EXPECT_DOUBLE_EQ(ParityDifference({0, 0}, {0, 2}), 2);
  EXPECT_EQ(ParityDifference({1, 2}, {1}), INFINITY);
}

TEST(ParityDifference, LosesNoNumberThatIsNotFinite) {
  for (int at = 0; at < 3; ++at) {
    for (const float bad : {NAN, INFINITY, -INFINITY}) {
      std::vector<float> values = {1, 2, 3};
      values[at] = bad;
      EXPECT_EQ(ParityDifference({1, 2, 3}, values), INFINITY) << at << bad;
      EXPECT_EQ(ParityDifference(values, {1, 2, 3}), INFINITY) << at << bad;
    }
  }
}

TEST(CheckParity, NamesTapAndBackEndBeyondTheTolerance) {
  const auto row = [](double torch, double onnx) {
    return ParityRow{
        .graph = "prior", .tap = "mean", .torch = torch, .onnx = onnx};
  };
  EXPECT_THAT(CheckParity({row(9e-6, 9e-6)}), IsOk());
  EXPECT_THAT(CheckParity({row(9e-6, 9e-6), row(2e-7, 2e-5)}),
              StatusIs(absl::StatusCode::kInternal,
                       HasSubstr("graph \"prior\": tap \"mean\": expected "
                                 "onnxruntime within 1e-05 of the executor, "
                                 "found 2.00e-05")));
  EXPECT_THAT(CheckParity({row(NAN, 0)}),
              StatusIs(absl::StatusCode::kInternal, HasSubstr("libtorch")));
}

}  // namespace
}  // namespace sinew::tools
