#ifndef SINEW_SIM_IMPORT_RETARGET_REFINE_TERMS_H_
#define SINEW_SIM_IMPORT_RETARGET_REFINE_TERMS_H_

#include <Eigen/Dense>
#include <vector>

#include "sim/import/retarget/contact_fit.h"
#include "sim/import/retarget/dynamics.h"
#include "sim/import/retarget/model_motion.h"
#include "sim/import/retarget/normal_equations.h"
#include "sim/import/retarget/refine.h"
#include "sim/import/retarget/self_contact.h"

namespace sinew::import {

// Frames at the ends of a motion that are final: terms reach them, nothing
// changes them.
struct HeldFrames {
  int before = 0;
  int after = 0;
};

// A motion and what its terms are made of.
struct RefineState {
  struct Frame {
    // Displacements to the frames beside; empty where one is missing.
    Eigen::VectorXd after, before;
    // Inverse dynamics, and what floor forces leave of it.
    Eigen::VectorXd required;
    ContactFit fit;
    std::vector<int> low;                // points the floor may reach
    std::vector<Eigen::Vector3d> soles;  // of bearing points of feet, lowest
    double cost = 0;                     // of all terms but fit's
  };
  ModelMotion motion;
  std::vector<Frame> frames;
  double cost = 0;  // sum of squares of all terms
};

// The least-squares problem behind RefineMotion: its terms at a motion, and
// their linearisation there. Coordinates are the tangent of qpos. Motions are
// those of `original` in number of frames, rate and cycle, the same in held
// frames.
//
// Thread-safety: one thread. Ownership: borrows all arguments. Blocking: never;
// a few hundred microseconds per frame for state and linearisation together.
class RefineTerms {
 public:
  RefineTerms(Dynamics* dynamics, const ModelMotion& original,
              const std::vector<std::vector<bool>>& bearing,
              const RefineOptions& options, HeldFrames held = {});

  // Chooses the points that floor forces may act at from the heights in
  // `motion`; they stay until ChooseContacts.
  RefineState Begin(ModelMotion motion);
  // `near` is a state of a similar motion: where the fits of forces start.
  RefineState Evaluate(ModelMotion motion, const RefineState& near);
  // Chooses them again, and brings the state up to date.
  void ChooseContacts(RefineState* state);

  // Whether, in a frame that is not held, two bodies are deeper in one another
  // than any are in the original.
  bool BodiesMeet(const ModelMotion& motion);

  // Equations of the frames that are not held, in order.
  NormalEquations MakeEquations() const;
  void Linearise(const RefineState& state, NormalEquations* equations);
  // The state's motion, each free frame moved by its step.
  ModelMotion Moved(const RefineState& state,
                    const std::vector<Eigen::VectorXd>& steps) const;

 private:
  // A frame near another one: where it is stored, and how its coordinates
  // appear there (the cycle turns the root's translation).
  struct Neighbour {
    int frame;
    Eigen::Matrix3d turn;
  };
  // What moves the soles of a frame: the axes of each foot's chain, [feet] of
  // [6, chain]; empty where none bears.
  struct FeetMoves {
    Eigen::Vector3d pivot;
    std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> axes;
  };

  Neighbour Find(const ModelMotion& motion, int t) const;
  bool HasNeighbours(int t) const;
  bool HasNext(int t) const;
  // Place of a stored frame among the unknowns; negative if held.
  int Unknown(int frame) const;
  // Where a position in the frame stored for `t` is in frame t.
  Eigen::Vector3d Seen(const ModelMotion& motion, int t,
                       const Eigen::Vector3d& position) const;

  void EvaluateFrame(const ModelMotion& motion, int t,
                     RefineState::Frame* frame);
  // With the dynamics in the frame's pose.
  void FitForces(int t, const RefineState::Frame* near,
                 RefineState::Frame* frame) const;
  double PoseCost(const ModelMotion& motion, int t) const;
  // Of the pose that the dynamics are in.
  double SelfCost(int t) const;
  double SlipCost(const RefineState& state, int t) const;
  void SumCosts(RefineState* state) const;

  void NoteFeet(int t);
  void AddPose(const ModelMotion& motion, int t,
               NormalEquations* equations) const;
  void AddHeights(int t, NormalEquations* equations) const;
  void AddSelf(int t, NormalEquations* equations) const;
  void AddSmoothness(const RefineState& state, int t,
                     NormalEquations* equations) const;
  void AddPhysics(const RefineState& state, int t, NormalEquations* equations);
  // Fills last_, here_ and next_ with the derivatives of the weighted remainder
  // by velocity and acceleration towards the frames beside, and by the pose;
  // returns the remainder. Rows that floor forces reach come first.
  Eigen::VectorXd DifferentiateForces(const ContactFit& fit, double rate);
  void AddSlip(const RefineState& state, int t,
               NormalEquations* equations) const;

  // Calls visit(a, b) for the places of every point that is in both lists,
  // which ascend.
  template <typename Visit>
  static void VisitSlips(const std::vector<int>& here,
                         const std::vector<int>& there, const Visit& visit) {
    for (size_t a = 0, b = 0; a < here.size() && b < there.size();) {
      if (here[a] == there[b]) visit(a, b);
      const bool behind = here[a] <= there[b];
      b += here[a] >= there[b] ? 1 : 0;
      a += behind ? 1 : 0;
    }
  }

  Dynamics* const dynamics_;
  const ModelMotion& original_;
  const std::vector<std::vector<bool>>& bearing_;
  const RefineOptions options_;
  const HeldFrames held_;
  const int frames_;
  const int nv_;
  const SelfContacts self_contacts_;
  std::vector<double> self_depths_;      // [frames] of the original, m; if self
  const Eigen::VectorXd pose_weights_;   // [nv]
  const Eigen::VectorXd force_weights_;  // [nv]
  // [frames] second differences of the original; empty without neighbours.
  std::vector<Eigen::VectorXd> original_change_;
  std::vector<std::vector<int>> soles_;     // [frames] bearing points of feet
  std::vector<std::vector<int>> may_bear_;  // [frames] of points
  // Scratch of Linearise.
  std::vector<FeetMoves> feet_moves_;   // [frames]
  Eigen::MatrixXd last_, here_, next_;  // [nv, nv]
};

}  // namespace sinew::import

#endif  // SINEW_SIM_IMPORT_RETARGET_REFINE_TERMS_H_
