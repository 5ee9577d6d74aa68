#include "sim/import/formats/smpl_npz.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/status_macros.h"
#include "sim/import/formats/axes.h"
#include "sim/import/formats/file_frame.h"
#include "sim/import/formats/npz.h"
#include "sim/import/formats/smpl_skeleton.h"
#include "sim/import/formats/text_lines.h"
#include "sim/motion/rotation.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Beyond them numbers cannot be what they should.
constexpr double kMaxAngle = 1000;    // rad
constexpr double kMaxPosition = 1e6;  // m
// A shape coefficient is in standard deviations of the population.
constexpr double kOddShape = 3;

absl::Status MemberError(const NpzFile& file, const std::string& member,
                         const std::string& what) {
  return absl::InvalidArgumentError(
      absl::StrCat(file.Label(member), ": ", what));
}

// The first of the names that the file has.
std::optional<std::string> FindMember(
    const NpzFile& file, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (file.Has(name)) return name;
  }
  return std::nullopt;
}

// An array of T rows.
class Table {
 public:
  // Reads a member whose rows have one of the numbers of columns; rows may be
  // split in groups of three. Its size is known good before it is read.
  static absl::StatusOr<Table> Read(const NpzFile& file,
                                    const std::string& member,
                                    std::initializer_list<int> columns,
                                    double rate) {
    SINEW_ASSIGN_OR_RETURN(const NpyHeader header, file.ReadHeader(member));
    const std::vector<int64_t>& shape = header.shape;
    const bool fits =
        !header.is_text() &&
        (shape.size() == 2 || (shape.size() == 3 && shape[2] == 3));
    const int64_t found =
        fits ? header.count() / std::max<int64_t>(shape[0], 1) : 0;
    if (!fits || (shape[0] > 0 && std::find(columns.begin(), columns.end(),
                                            found) == columns.end())) {
      return MemberError(file, member,
                         absl::StrCat("expected numbers (frames, ",
                                      absl::StrJoin(columns, " or "),
                                      "), found ", header.ToString()));
    }
    if (shape[0] < 2) {
      return MemberError(file, member,
                         absl::StrCat("expected at least 2 frames, found ",
                                      header.ToString()));
    }
    if ((shape[0] - 1) / rate > kMaxClipSeconds) {
      return absl::ResourceExhaustedError(absl::StrFormat(
          "%s: expected at most %g seconds, found %g (%d frames at %g a "
          "second)",
          file.Label(member), kMaxClipSeconds, (shape[0] - 1) / rate, shape[0],
          rate));
    }
    constexpr int64_t kMostFrames =
        static_cast<int64_t>(kMaxRotations) / 24;  // joints of a pose
    if (shape[0] > kMostFrames) {
      return absl::ResourceExhaustedError(
          absl::StrCat(file.Label(member), ": expected at most ", kMostFrames,
                       " frames, found ", header.ToString()));
    }
    SINEW_ASSIGN_OR_RETURN(NpyArray array, file.ReadArray(member));
    return Table(file.Label(member), found, std::move(array));
  }

  int64_t rows() const { return array_.shape()[0]; }
  int64_t columns() const { return columns_; }
  const std::string& label() const { return label_; }

  // Columns `first` to first + 2 of a row; all within +-limit.
  absl::StatusOr<Vector3d> Vector(int64_t row, int64_t first,
                                  double limit) const {
    Vector3d vector;
    for (int64_t i = 0; i < 3; ++i) {
      const double value = array_.Number(row * columns_ + first + i);
      if (!(std::abs(value) <= limit)) {
        return absl::InvalidArgumentError(absl::StrFormat(
            "%s: frame %d, column %d: expected a number within +-%g, found %g",
            label_, row, first + i, limit, value));
      }
      vector[i] = value;
    }
    return vector;
  }

 private:
  Table(std::string label, int64_t columns, NpyArray array)
      : label_(std::move(label)), columns_(columns), array_(std::move(array)) {}

  std::string label_;
  int64_t columns_;
  NpyArray array_;
};

absl::StatusOr<double> ReadRate(const NpzFile& file,
                                const ReadOptions& options) {
  if (options.frames_per_second.has_value()) return *options.frames_per_second;
  const auto member = FindMember(
      file, {"mocap_framerate", "mocap_frame_rate", "fps", "frame_rate"});
  if (!member.has_value()) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.Label("mocap_framerate"),
                     ": expected the number of frames per second here, in "
                     "mocap_frame_rate, fps or frame_rate, or given, found ",
                     file.Names()));
  }
  SINEW_ASSIGN_OR_RETURN(const NpyArray array, file.ReadArray(*member));
  if (array.header().is_text() || array.count() != 1) {
    return MemberError(
        file, *member,
        absl::StrCat("expected one number, found ", array.header().ToString()));
  }
  const double rate = array.Number(0);
  if (!(rate > 0 && rate <= kMaxFramesPerSecond)) {
    return MemberError(file, *member,
                       absl::StrFormat("expected more than 0 and at most %g "
                                       "frames per second, found %g",
                                       kMaxFramesPerSecond, rate));
  }
  return rate;
}

// The tables whose columns, one after the other, are the joints' vectors.
absl::StatusOr<std::vector<Table>> ReadPoses(const NpzFile& file, double rate) {
  std::vector<Table> tables;
  const auto whole = FindMember(file, {"poses", "pose_aa"});
  if (whole.has_value()) {
    SINEW_ASSIGN_OR_RETURN(Table table,
                           Table::Read(file, *whole, {66, 72, 156, 165}, rate));
    tables.push_back(std::move(table));
    return tables;
  }
  if (!file.Has("root_orient") || !file.Has("pose_body")) {
    return absl::InvalidArgumentError(
        absl::StrCat(file.Label("poses"),
                     ": expected a member of this name, pose_aa, or "
                     "root_orient and pose_body, found ",
                     file.Names()));
  }
  SINEW_ASSIGN_OR_RETURN(Table root,
                         Table::Read(file, "root_orient", {3}, rate));
  SINEW_ASSIGN_OR_RETURN(Table body,
                         Table::Read(file, "pose_body", {63, 69}, rate));
  tables.push_back(std::move(root));
  tables.push_back(std::move(body));
  return tables;
}

absl::Status CheckRows(const Table& table, const Table& other) {
  if (table.rows() == other.rows()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(table.label(), ": expected ", other.rows(), " frames as in ",
                   other.label(), ", found ", table.rows()));
}

// World rotation of the root as in the file, and the others' in the axes of
// smpl_skeleton.h.
absl::StatusOr<std::vector<Quaterniond>> ReadRotations(
    const std::vector<Table>& tables, int64_t row) {
  const Quaterniond to_z_up = ToZUp('y');
  std::vector<Quaterniond> rotations;
  size_t table = 0;
  int64_t column = 0;
  for (int joint = 0; joint < kSmplBodyJoints; ++joint) {
    if (column == tables[table].columns()) {
      ++table;
      column = 0;
    }
    SINEW_ASSIGN_OR_RETURN(const Vector3d vector,
                           tables[table].Vector(row, column, kMaxAngle));
    column += 3;
    rotations.push_back(joint == 0 ? motion::Exp(vector) * to_z_up.conjugate()
                                   : motion::Exp(to_z_up * vector));
  }
  rotations.resize(SmplSkeleton().joints.size(), Quaterniond::Identity());
  return rotations;
}

// Frames in the world of the file, without times.
absl::Status ReadFrames(const std::vector<Table>& poses, const Table& trans,
                        double metres_per_unit, SourceClip* clip) {
  for (int64_t row = 0; row < trans.rows(); ++row) {
    SourcePose pose;
    SINEW_ASSIGN_OR_RETURN(const Vector3d moved,
                           trans.Vector(row, 0, kMaxPosition));
    pose.root_position = moved * metres_per_unit + SmplPelvis();
    SINEW_ASSIGN_OR_RETURN(pose.rotation, ReadRotations(poses, row));
    clip->poses.push_back(std::move(pose));
  }
  return absl::OkStatus();
}

// 'y' if the body stands along it in the mean, else 'z'.
char ConcludeUpAxis(const SourceClip& clip) {
  Vector3d up = Vector3d::Zero();
  for (const SourcePose& pose : clip.poses) {
    up += pose.rotation[0] * Vector3d::UnitZ();
  }
  up /= static_cast<double>(clip.poses.size());
  return up.y() > 0.7 && std::abs(up.z()) < 0.3 ? 'y' : 'z';
}

void TurnUp(char up_axis, SourceClip* clip) {
  const Quaterniond turn = ToZUp(up_axis);
  for (SourcePose& pose : clip->poses) {
    pose.root_position = turn * pose.root_position;
    pose.rotation[0] = turn * pose.rotation[0];
  }
}

// Says what of the body's shape is left out, if that is much. Nothing depends
// on it, so that what cannot be read is no error.
void WarnOfShape(const NpzFile& file, SourceClip* clip) {
  const absl::StatusOr<NpyArray> betas = file.ReadArray("betas");
  if (!betas.ok() || betas->header().is_text()) return;
  double largest = 0;
  for (int64_t i = 0; i < betas->count(); ++i) {
    largest = std::max(largest, std::abs(betas->Number(i)));
  }
  if (!(largest > kOddShape)) return;
  std::string gender = "gender unknown";
  if (const auto array = file.ReadArray("gender"); array.ok()) {
    gender = array->Text("").value_or(gender).substr(0, 16);
  }
  clip->warnings.push_back(absl::StrFormat(
      "the body (%s, shape coefficients up to %.1f) is far from the mean one, "
      "whose bone lengths are used",
      absl::CHexEscape(gender), largest));
}

}  // namespace

absl::StatusOr<SourceClip> ParseSmplNpz(absl::string_view bytes,
                                        absl::string_view name,
                                        absl::string_view source,
                                        const ReadOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckReadOptions(options));
  SINEW_RETURN_IF_ERROR(CheckFileSize(bytes, kSmplMaxBytes, source));
  SINEW_ASSIGN_OR_RETURN(const NpzFile file, NpzFile::Open(bytes, source));
  SINEW_ASSIGN_OR_RETURN(const double rate, ReadRate(file, options));
  SINEW_ASSIGN_OR_RETURN(const std::vector<Table> poses, ReadPoses(file, rate));
  SINEW_ASSIGN_OR_RETURN(
      const Table trans,
      Table::Read(file, FindMember(file, {"trans", "transl"}).value_or("trans"),
                  {3}, rate));
  for (const Table& table : poses) {
    SINEW_RETURN_IF_ERROR(CheckRows(table, trans));
  }
  SourceClip clip;
  clip.name = std::string(name);
  clip.skeleton = SmplSkeleton();
  const double metres_per_unit = options.metres_per_unit.value_or(1);
  SINEW_RETURN_IF_ERROR(ReadFrames(poses, trans, metres_per_unit, &clip));
  SINEW_RETURN_IF_ERROR(SetTimes(rate, source, clip));
  WarnOfShape(file, &clip);
  const char up_axis = options.up_axis.value_or(ConcludeUpAxis(clip));
  TurnUp(up_axis, &clip);
  clip.facts.set_format("smpl_npz");
  clip.facts.set_metres_per_unit(metres_per_unit);
  clip.facts.set_up_axis(std::string(1, up_axis));
  if (!options.up_axis.has_value() && up_axis != 'z') {
    clip.facts.add_concluded("up_axis");
  }
  return clip;
}

}  // namespace sinew::import
