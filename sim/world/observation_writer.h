#ifndef SINEW_SIM_WORLD_OBSERVATION_WRITER_H_
#define SINEW_SIM_WORLD_OBSERVATION_WRITER_H_

#include <Eigen/Geometry>

namespace sinew::world {

// Writes columns of an observation one after another. Thread-safety: one
// caller. Ownership: borrows the columns. Blocking: never. Errors: none; the
// caller has made room.
class ObservationWriter {
 public:
  // Names of the columns that Vector and Rotation write.
  static constexpr const char* kVectorNames[] = {"x", "y", "z"};
  static constexpr const char* kRotationNames[] = {"00", "10", "20",
                                                   "01", "11", "21"};

  explicit ObservationWriter(float* out) : out_(out) {}

  void Scalar(double value) { *out_++ = static_cast<float>(value); }
  void Vector(const Eigen::Vector3d& value) {
    for (int i = 0; i < 3; ++i) Scalar(value[i]);
  }
  // The first two columns of the matrix.
  void Rotation(const Eigen::Quaterniond& rotation) {
    const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
    Vector(matrix.col(0));
    Vector(matrix.col(1));
  }
  const float* position() const { return out_; }

 private:
  float* out_;
};

}  // namespace sinew::world

#endif  // SINEW_SIM_WORLD_OBSERVATION_WRITER_H_
