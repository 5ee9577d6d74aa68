#include "sim/import/testing/made_clips.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "common/files.h"
#include "sim/import/formats/deepmimic.h"

namespace sinew::import::testing {
namespace {

// Columns of a frame.
enum Column {
  kSeconds = 0,
  kPosition = 1,
  kRoot = 4,
  kChest = 8,
  kNeck = 12,
  kRightHip = 16,
  kRightKnee = 20,
  kRightAnkle = 21,
  kRightShoulder = 25,
  kRightElbow = 29,
  kLeftHip = 30,
  kLeftKnee = 34,
  kLeftAnkle = 35,
  kLeftShoulder = 39,
  kLeftElbow = 43,
};

// Height of the root over the soles of the rest pose, m.
constexpr double kStanding = 0.89;
constexpr double kFrameSeconds = 1.0 / 30;

std::vector<double> RestRow() {
  std::vector<double> row(kDeepMimicColumns, 0);
  row[kSeconds] = kFrameSeconds;
  row[kPosition + 1] = kStanding;
  for (const int w : {kRoot, kChest, kNeck, kRightHip, kRightAnkle,
                      kRightShoulder, kLeftHip, kLeftAnkle, kLeftShoulder}) {
    row[w] = 1;
  }
  return row;
}

// A turn about the file's z axis, which points right.
void Bend(int column, double angle, std::vector<double>* row) {
  (*row)[column] = std::cos(angle / 2);
  (*row)[column + 3] = std::sin(angle / 2);
}

std::string ToJson(const std::vector<std::vector<double>>& rows,
                   absl::string_view loop) {
  const auto number = [](std::string* out, double value) {
    absl::StrAppend(out, absl::StrFormat("%.9f", value));
  };
  std::vector<std::string> frames;
  for (const auto& row : rows) {
    frames.push_back(absl::StrCat("[", absl::StrJoin(row, ", ", number), "]"));
  }
  return absl::StrCat("{\"Loop\": \"", loop, "\",\n\"Frames\": [\n",
                      absl::StrJoin(frames, ",\n"), "]}\n");
}

// Hip, knee and ankle of one leg at phase `s` (rad) of its cycle.
void Leg(double s, int hip, int knee, int ankle, std::vector<double>* row) {
  const double lift = std::max(0.0, std::sin(s));
  const double flexed = 0.8 * lift * lift;
  const double swing = 0.25 * -std::cos(s) + flexed / 2;
  Bend(hip, swing, row);
  (*row)[knee] = -flexed;
  Bend(ankle, flexed - swing, row);  // the sole stays level
}

}  // namespace

std::string MarchJson(double floating) {
  std::vector<std::vector<double>> rows;
  for (int t = 0; t <= 30; ++t) {
    const double s = 2 * std::numbers::pi * t / 30;
    std::vector<double> row = RestRow();
    row[kPosition] = 0.8 * t / 30;
    row[kPosition + 1] += floating;
    Leg(s, kRightHip, kRightKnee, kRightAnkle, &row);
    Leg(s + std::numbers::pi, kLeftHip, kLeftKnee, kLeftAnkle, &row);
    Bend(kRightShoulder, 0.3 * std::cos(s), &row);
    Bend(kLeftShoulder, -0.3 * std::cos(s), &row);
    Bend(kChest, 0.05 * std::sin(2 * s), &row);
    rows.push_back(row);
  }
  return ToJson(rows, "wrap");
}

std::string LyingJson() {
  std::vector<double> row = RestRow();
  row[kPosition + 1] = 0.6;
  Bend(kRoot, std::numbers::pi / 2, &row);
  return ToJson(std::vector<std::vector<double>>(31, row), "none");
}

std::vector<std::string> RecordedClips() {
  const char* data = std::getenv("SINEW_DATA");
  std::vector<std::string> clips;
  if (data == nullptr) return clips;
  for (const char* name : {"walk", "run", "jump"}) {
    const std::string path = JoinPath(
        data, absl::StrCat("motions/deepmimic/humanoid3d_", name, ".txt"));
    if (FileSize(path).ok()) clips.push_back(path);
  }
  return clips;
}

}  // namespace sinew::import::testing
