#include "sim/import/formats/testing/made_files.h"

#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"

namespace sinew::import::testing {
namespace {

struct AsfLine {
  const char* name;
  const char* parent;
  const char* direction;
  double length;
  const char* axis;
  const char* dof;  // "" for none
};

constexpr AsfLine kAsf[] = {
    {"lhipjoint", "root", "0.65 -0.72 0.25", 2.5, "0 0 0", ""},
    {"lfemur", "lhipjoint", "0.34202 -0.93969 0", 7.5, "0 0 20", "rx ry rz"},
    {"ltibia", "lfemur", "0.34202 -0.93969 0", 7.2, "0 0 20", "rx"},
    {"lfoot", "ltibia", "0.1 -0.25 0.96", 2.2, "-90 0 20", "rx rz"},
    {"ltoes", "lfoot", "0 0 1", 1.1, "-90 0 20", "rx"},
    {"rhipjoint", "root", "-0.65 -0.72 0.25", 2.5, "0 0 0", ""},
    {"rfemur", "rhipjoint", "-0.34202 -0.93969 0", 7.5, "0 0 -20", "rx ry rz"},
    {"rtibia", "rfemur", "-0.34202 -0.93969 0", 7.2, "0 0 -20", "rx"},
    {"rfoot", "rtibia", "-0.1 -0.25 0.96", 2.2, "-90 0 -20", "rx rz"},
    {"rtoes", "rfoot", "0 0 1", 1.1, "-90 0 -20", "rx"},
    {"lowerback", "root", "0 1 -0.06", 2, "0 0 0", "rx ry rz"},
    {"upperback", "lowerback", "0 1 0", 2, "0 0 0", "rx ry rz"},
    {"thorax", "upperback", "0 1 0", 2, "0 0 0", "rx ry rz"},
    {"lowerneck", "thorax", "0 1 0", 1.6, "0 0 0", "rx ry rz"},
    {"upperneck", "lowerneck", "0 1 0", 1.6, "0 0 0", "rx ry rz"},
    {"head", "upperneck", "0 1 0", 1.6, "0 0 0", "rx ry rz"},
    {"lclavicle", "thorax", "0.97 0.25 0", 3.6, "0 0 0", "ry rz"},
    {"lhumerus", "lclavicle", "1 0 0", 5, "180 30 90", "rx ry rz"},
    {"lradius", "lhumerus", "1 0 0", 3.3, "180 30 90", "rx"},
    {"lwrist", "lradius", "1 0 0", 1.6, "180 30 90", "ry"},
    {"lhand", "lwrist", "1 0 0", 0.7, "180 30 90", "rx rz"},
    {"lfingers", "lhand", "1 0 0", 0.5, "180 30 90", "rx"},
    {"lthumb", "lwrist", "0.7 0 0.7", 0.8, "-90 45 0", "rx rz"},
    {"rclavicle", "thorax", "-0.97 0.25 0", 3.6, "0 0 0", "ry rz"},
    {"rhumerus", "rclavicle", "-1 0 0", 5, "180 -30 -90", "rx ry rz"},
    {"rradius", "rhumerus", "-1 0 0", 3.3, "180 -30 -90", "rx"},
    {"rwrist", "rradius", "-1 0 0", 1.6, "180 -30 -90", "ry"},
    {"rhand", "rwrist", "-1 0 0", 0.7, "180 -30 -90", "rx rz"},
    {"rfingers", "rhand", "-1 0 0", 0.5, "180 -30 -90", "rx"},
    {"rthumb", "rwrist", "-0.7 0 0.7", 0.8, "-90 -45 0", "rx rz"},
};

int NumDofs(const AsfLine& line) {
  if (line.dof[0] == '\0') return 0;
  return static_cast<int>(
      std::vector<std::string>(absl::StrSplit(line.dof, ' ')).size());
}

struct BvhLine {
  const char* name;
  int parent;
  const char* offset;
  const char* rotation;  // in every frame, z y x
};

// Standing: x goes up the trunk, y forward and z to the left; legs hang by half
// a turn about y, collars point aside, arms hang.
constexpr BvhLine kLafan[] = {
    {"Hips", -1, "-211.1 90.1 -345.2", "90 0 0"},
    {"LeftUpLeg", 0, "0.1 1.9 10.5", "0 180 0"},
    {"LeftLeg", 1, "43.5 0 0", "0 0 0"},
    {"LeftFoot", 2, "42.4 0 0", "70 0 0"},
    {"LeftToe", 3, "17.3 0 0", "20 0 0"},
    {"RightUpLeg", 0, "0.1 1.9 -10.5", "0 180 0"},
    {"RightLeg", 5, "43.5 0 0", "0 0 0"},
    {"RightFoot", 6, "42.4 0 0", "70 0 0"},
    {"RightToe", 7, "17.3 0 0", "20 0 0"},
    {"Spine", 0, "6.9 -2.6 0", "0 0 0"},
    {"Spine1", 9, "12.6 0 0", "0 0 0"},
    {"Spine2", 10, "12.3 0 0", "0 0 0"},
    {"Neck", 11, "25.8 0 0", "0 0 0"},
    {"Head", 12, "11.8 0 0", "0 0 0"},
    {"LeftShoulder", 11, "19.7 -1.5 6", "0 -90 180"},
    {"LeftArm", 14, "11.3 0 0", "0 90 0"},
    {"LeftForeArm", 15, "33 0 0", "0 0 0"},
    {"LeftHand", 16, "25.2 0 0", "0 0 0"},
    {"RightShoulder", 11, "19.7 -1.5 -6", "0 90 -180"},
    {"RightArm", 18, "11.3 0 0", "0 -90 0"},
    {"RightForeArm", 19, "33 0 0", "0 0 0"},
    {"RightHand", 20, "25.2 0 0", "0 0 0"},
};
constexpr int kLafanJoints = sizeof(kLafan) / sizeof(kLafan[0]);

std::string LafanJoint(int joint) {
  const BvhLine& line = kLafan[joint];
  std::string text = absl::StrCat(
      joint == 0 ? "ROOT " : "JOINT ", line.name, "\n{\nOFFSET ", line.offset,
      "\nCHANNELS ", joint == 0 ? "6 Xposition Yposition Zposition " : "3 ",
      "Zrotation Yrotation Xrotation\n");
  bool has_children = false;
  for (int child = joint + 1; child < kLafanJoints; ++child) {
    if (kLafan[child].parent != joint) continue;
    absl::StrAppend(&text, LafanJoint(child));
    has_children = true;
  }
  if (!has_children) absl::StrAppend(&text, "End Site\n{\nOFFSET 5 0 0\n}\n");
  return absl::StrCat(text, "}\n");
}

}  // namespace

std::string MadeAsf() {
  std::string text =
      "# made\n:version 1.10\n:name MADE\n:units\n  mass 1.0\n  length 0.45\n"
      "  angle deg\n:documentation\n  begin nothing\n:root\n"
      "  order TX TY TZ RX RY RZ\n  axis XYZ\n  position 0 0 0\n"
      "  orientation 0 0 0\n:bonedata\n";
  for (const AsfLine& line : kAsf) {
    absl::StrAppend(&text, "  begin\n    name ", line.name, "\n    direction ",
                    line.direction, "\n    length ", line.length, "\n    axis ",
                    line.axis, "  XYZ\n");
    if (NumDofs(line) > 0) {
      absl::StrAppend(&text, "    dof ", line.dof,
                      "\n    limits (-160.0 20.0)\n           (-70 70)\n");
    }
    absl::StrAppend(&text, "  end\n");
  }
  absl::StrAppend(&text, ":hierarchy\n  begin\n");
  for (const AsfLine& line : kAsf) {
    absl::StrAppend(&text, "    ", line.parent, " ", line.name, "\n");
  }
  return absl::StrCat(text, "  end\n");
}

std::string MadeAmc(int frames) {
  std::string text = "#!made\n:FULLY-SPECIFIED\n:DEGREES\n";
  for (int i = 0; i < frames; ++i) {
    const double swing = 30 * std::sin(0.1 * i);
    absl::StrAppend(&text, i + 1, "\nroot 0 17 ", 0.15 * i, " 0 0 0\n");
    for (const AsfLine& line : kAsf) {
      const int count = NumDofs(line);
      if (count == 0) continue;
      absl::StrAppend(&text, line.name);
      const bool is_left = line.name[0] == 'l';
      for (int dof = 0; dof < count; ++dof) {
        absl::StrAppend(&text, " ",
                        dof == 0 ? (is_left ? swing : -swing) : dof);
      }
      absl::StrAppend(&text, "\n");
    }
  }
  return text;
}

std::string MadeLafanBvh(int frames) {
  std::string text =
      absl::StrCat("HIERARCHY\n", LafanJoint(0), "MOTION\nFrames: ", frames,
                   "\nFrame Time: 0.033333\n");
  for (int i = 0; i < frames; ++i) {
    absl::StrAppendFormat(&text, "10 92 %g", 5 + 4.0 * i);
    for (const BvhLine& line : kLafan) {
      absl::StrAppend(&text, " ", line.rotation);
    }
    absl::StrAppend(&text, "\n");
  }
  return text;
}

}  // namespace sinew::import::testing
