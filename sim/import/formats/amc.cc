#include <map>
#include <numbers>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "common/status_macros.h"
#include "sim/import/formats/asf_amc.h"
#include "sim/import/formats/file_frame.h"
#include "sim/import/formats/text_lines.h"

namespace sinew::import {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kInch = 0.0254;

class Parser {
 public:
  Parser(absl::string_view bytes, const AsfSkeleton& asf,
         absl::string_view source)
      : lines_(bytes),
        asf_(asf),
        source_(source),
        max_rotations_(MaxRotations(bytes.size())),
        unit_(asf.angles_in_degrees ? kDegree : 1) {
    for (size_t i = 0; i < asf.bones.size(); ++i) {
      index_[asf.bones[i].name] = i;
      if (!asf.bones[i].channels.empty()) ++num_moving_;
    }
  }

  absl::StatusOr<std::vector<SourcePose>> Parse() {
    while (lines_.Next()) {
      absl::string_view rest = lines_.text();
      if (rest.empty() || rest[0] == '#') continue;
      const absl::string_view word = TakeWord(&rest);
      int number = 0;
      if (word[0] == ':') {
        SINEW_RETURN_IF_ERROR(ReadKeyword(word, rest));
      } else if (rest.empty() && absl::SimpleAtoi(word, &number)) {
        SINEW_RETURN_IF_ERROR(StartFrame(number));
      } else {
        SINEW_RETURN_IF_ERROR(ReadBone(word, rest));
      }
    }
    if (poses_.empty()) return Error("expected at least one frame, found none");
    SINEW_RETURN_IF_ERROR(EndFrame());
    return std::move(poses_);
  }

  // 0: the file does not say.
  double frames_per_second() const { return frames_per_second_; }

 private:
  absl::Status Error(absl::string_view what) const {
    if (poses_.empty()) return LineError(source_, lines_.number(), what);
    return LineError(source_, lines_.number(),
                     absl::StrCat("frame ", frame_, ": ", what));
  }

  absl::Status ReadKeyword(absl::string_view word, absl::string_view rest) {
    if (absl::EqualsIgnoreCase(word, ":DEGREES")) {
      unit_ = kDegree;
    } else if (absl::EqualsIgnoreCase(word, ":RADIANS")) {
      unit_ = 1;
    } else if (absl::EqualsIgnoreCase(word, ":SAMPLES-PER-SECOND")) {
      const absl::StatusOr<double> rate = ParseNumber(TakeWord(&rest));
      if (!rate.ok() ||
          !(*rate >= kMinFramesPerSecond && *rate <= kMaxFramesPerSecond)) {
        return Error(absl::StrCat(
            "expected ", kMinFramesPerSecond, " to ", kMaxFramesPerSecond,
            " samples per second, found ", Quoted(lines_.text())));
      }
      frames_per_second_ = *rate;
    }
    return absl::OkStatus();
  }

  absl::Status StartFrame(int number) {
    if (!poses_.empty()) {
      SINEW_RETURN_IF_ERROR(EndFrame());
      if (number != frame_ + 1) {
        return Error(
            absl::StrCat("expected the next frame after it, found ", number));
      }
    }
    const size_t joints = asf_.skeleton.joints.size();
    SINEW_RETURN_IF_ERROR(
        CheckRotations(joints, poses_.size() + 1, max_rotations_, source_));
    frame_ = number;
    SourcePose pose;
    pose.root_position = asf_.root_position;
    pose.rotation.assign(joints, Quaterniond::Identity());
    poses_.push_back(std::move(pose));
    seen_.assign(asf_.bones.size(), false);
    num_seen_ = 0;
    return absl::OkStatus();
  }

  absl::Status EndFrame() const {
    if (num_seen_ == num_moving_) return absl::OkStatus();
    for (size_t i = 0; i < asf_.bones.size(); ++i) {
      if (seen_[i] || asf_.bones[i].channels.empty()) continue;
      return Error(absl::StrCat("expected numbers of bone ",
                                Quoted(asf_.bones[i].name),
                                ", found the end of the frame"));
    }
    return absl::OkStatus();
  }

  absl::Status ReadBone(absl::string_view name, absl::string_view rest) {
    if (poses_.empty()) {
      return Error(
          absl::StrCat("expected the number of a frame, found ", Quoted(name)));
    }
    const auto found = index_.find(name);
    if (found == index_.end()) {
      return Error(absl::StrCat("expected a bone of the skeleton, found ",
                                Quoted(name)));
    }
    const AsfBone& bone = asf_.bones[found->second];
    if (seen_[found->second]) {
      return Error(absl::StrCat("expected each bone once, found ", Quoted(name),
                                " twice"));
    }
    seen_[found->second] = true;
    if (!bone.channels.empty()) ++num_seen_;
    return ReadNumbers(bone, rest);
  }

  absl::Status ReadNumbers(const AsfBone& bone, absl::string_view rest) {
    SourcePose& pose = poses_.back();
    Quaterniond turn = Quaterniond::Identity();
    for (const AsfChannel& channel : bone.channels) {
      const absl::string_view word = TakeWord(&rest);
      const absl::StatusOr<double> value = ParseNumber(word);
      if (!value.ok()) {
        return Error(absl::StrCat("bone ", Quoted(bone.name), ": expected ",
                                  bone.channels.size(),
                                  " numbers: ", value.status().message()));
      }
      if (channel.is_position) {
        pose.root_position[channel.axis] += *value;
      } else {
        turn = Eigen::AngleAxisd(*value * unit_, Vector3d::Unit(channel.axis)) *
               turn;
      }
    }
    if (!TakeWord(&rest).empty()) {
      return Error(absl::StrCat("bone ", Quoted(bone.name), ": expected ",
                                bone.channels.size(), " numbers, found more"));
    }
    pose.rotation[bone.joint] =
        (bone.axis * turn * bone.axis.conjugate()).normalized();
    return absl::OkStatus();
  }

  TextLines lines_;
  const AsfSkeleton& asf_;
  const absl::string_view source_;
  const size_t max_rotations_;
  std::map<std::string, size_t, std::less<>> index_;
  size_t num_moving_ = 0;  // bones that every frame has

  double unit_;  // rad per unit of angle
  double frames_per_second_ = 0;
  std::vector<SourcePose> poses_;
  // Of the last pose: its number, bones that it has had.
  int64_t frame_ = 0;
  std::vector<bool> seen_;
  size_t num_seen_ = 0;
};

// Concluded where nothing says it.
double Rate(double in_file, const ReadOptions& options, SourceClip& clip) {
  if (options.frames_per_second.has_value()) return *options.frames_per_second;
  if (in_file > 0) return in_file;
  clip.facts.add_concluded("frames_per_second");
  return kAmcFramesPerSecond;
}

}  // namespace

absl::StatusOr<SourceClip> ParseAmc(absl::string_view bytes,
                                    const AsfSkeleton& asf,
                                    absl::string_view name,
                                    absl::string_view source,
                                    const ReadOptions& options) {
  SINEW_RETURN_IF_ERROR(CheckReadOptions(options));
  SINEW_RETURN_IF_ERROR(CheckFileSize(bytes, kAmcMaxBytes, source));
  Parser parser(bytes, asf, source);
  SourceClip clip;
  SINEW_ASSIGN_OR_RETURN(clip.poses, parser.Parse());
  clip.name = std::string(name);
  clip.skeleton = asf.skeleton;
  clip.facts.set_format("asf_amc");
  FileFrame frame;
  if (asf.length.has_value()) frame.usual_metres_per_unit = kInch / *asf.length;
  MoveToWorld(frame, options, clip);
  SINEW_RETURN_IF_ERROR(
      SetTimes(Rate(parser.frames_per_second(), options, clip), source, clip));
  return clip;
}

}  // namespace sinew::import
