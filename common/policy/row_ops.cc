#include "common/policy/row_ops.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "common/policy/element_ops.h"
#include "common/policy/linear_kernel.h"
#include "common/policy/vector_math.h"

namespace sinew::policy::internal {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

void RunLinear(const StepArguments& a) {
  const Rows& x = a.input(0);
  const Rows& y = a.output();
  Linear({.rows = RoundUp(a.batch, kRowBlock),
          .k = x.width,
          .n = y.width,
          .x_stride = x.stride,
          .y_stride = y.stride},
         x.data, a.parameters[0].data(), a.parameters[1].data(), y.data);
}

void RunConvolution(const StepArguments& a) {
  const Convolution& c = a.step.convolution;
  const LinearShape shape = {.rows = RoundUp(c.out_length, kRowBlock),
                             .k = c.patch_width,
                             .n = c.out_channels,
                             .x_stride = c.patch_width,
                             .y_stride = RoundUp(c.out_channels, kPanel)};
  const int64_t elements = c.out_length * c.patch_width;
  for (int64_t r = 0; r < a.batch; ++r) {
    const float* x = a.input(0).row(r);
    float* y = a.output().row(r);
    for (int64_t i = 0; i < elements; ++i) {
      a.patches[i] = c.source[i] < 0 ? 0.0f : x[c.source[i]];
    }
    Linear(shape, a.patches, a.parameters[0].data(), a.parameters[1].data(),
           a.results);
    for (int64_t o = 0; o < c.out_channels; ++o) {
      for (int64_t t = 0; t < c.out_length; ++t) {
        y[o * c.out_length + t] = a.results[t * shape.y_stride + o];
      }
    }
  }
}

// Sum over a row of f(element), eight partial sums in fixed order.
template <typename F>
float RowSum(const float* x, int64_t width, F f) {
  Float8 sum = Splat(0.0f);
  for (int64_t i = 0; i < width; i += kLanes) {
    sum += Keep(f(Load(x + i)), width - i, 0.0f);
  }
  return Sum(sum);
}

void LayerNorm(const StepArguments& a) {
  const float* gain = a.parameters[0].data();
  const float* bias = a.parameters[1].data();
  const int64_t width = a.output().width;
  const float count = static_cast<float>(width);
  for (int64_t r = 0; r < a.batch; ++r) {
    const float* x = a.input(0).row(r);
    float* y = a.output().row(r);
    const float mean = RowSum(x, width, [](Float8 v) { return v; }) / count;
    const float variance =
        RowSum(x, width,
               [mean](Float8 v) {
                 return (v - Splat(mean)) * (v - Splat(mean));
               }) /
        count;
    const float scale = 1.0f / std::sqrt(variance + a.step.epsilon);
    for (int64_t i = 0; i < width; i += kLanes) {
      const Float8 centred = (Load(x + i) - Splat(mean)) * Splat(scale);
      Store(y + i, Fma(centred, Load(gain + i), Load(bias + i)));
    }
  }
}

void Softmax(const StepArguments& a) {
  const int64_t width = a.output().width;
  for (int64_t r = 0; r < a.batch; ++r) {
    const float* x = a.input(0).row(r);
    float* y = a.output().row(r);
    Float8 most = Splat(-std::numeric_limits<float>::infinity());
    for (int64_t i = 0; i < width; i += kLanes) {
      const Float8 v =
          Keep(Load(x + i), width - i, -std::numeric_limits<float>::infinity());
      most = v > most ? v : most;
    }
    const Float8 top = Splat(Max(most));
    for (int64_t i = 0; i < width; i += kLanes) {
      Store(y + i, Exp(Load(x + i) - top));
    }
    const float sum = RowSum(y, width, [](Float8 v) { return v; });
    for (int64_t i = 0; i < width; i += kLanes) {
      Store(y + i, Load(y + i) / Splat(sum));
    }
  }
}

void L2Normalise(const StepArguments& a) {
  const int64_t width = a.output().width;
  for (int64_t r = 0; r < a.batch; ++r) {
    const float* x = a.input(0).row(r);
    float* y = a.output().row(r);
    const float norm =
        std::sqrt(RowSum(x, width, [](Float8 v) { return v * v; }));
    const Float8 divisor = Splat(norm < a.step.epsilon ? a.step.epsilon : norm);
    for (int64_t i = 0; i < width; i += kLanes) {
      Store(y + i, Load(x + i) / divisor);
    }
  }
}

// Squared distances of x to the sixteen codes of a panel.
void PanelDistances(const float* x, int64_t width, const float* panel,
                    float distances[kPanel]) {
  Float8 left = Splat(0.0f);
  Float8 right = Splat(0.0f);
  for (int64_t k = 0; k < width; ++k) {
    const Float8 x_k = Splat(x[k]);
    const Float8 d_left = x_k - Load(panel + k * kPanel);
    const Float8 d_right = x_k - Load(panel + k * kPanel + kLanes);
    left = Fma(d_left, d_left, left);
    right = Fma(d_right, d_right, right);
  }
  Store(distances, left);
  Store(distances + kLanes, right);
}

void Argmin(const StepArguments& a) {
  const int64_t width = a.input(0).width;
  const float* codebook = a.parameters[0].data();
  for (int64_t r = 0; r < a.batch; ++r) {
    float distances[kPanel];
    float least = 0.0f;
    int64_t nearest = 0;
    for (int64_t j = 0; j < a.step.codes; ++j) {
      if (j % kPanel == 0) {
        PanelDistances(a.input(0).row(r), width, codebook + j * width,
                       distances);
      }
      const float distance = distances[j % kPanel];
      if (j == 0 || distance < least) {
        least = distance;
        nearest = j;
      }
    }
    a.output().row(r)[0] =
        std::isnan(least) ? kNan : static_cast<float>(nearest);
  }
}

void Gather(const StepArguments& a) {
  const int64_t width = a.output().width;
  for (int64_t r = 0; r < a.batch; ++r) {
    const float index = a.input(0).row(r)[0];
    float* y = a.output().row(r);
    if (index >= 0.0f && index < static_cast<float>(a.step.codes)) {
      const int64_t code = static_cast<int64_t>(index);
      std::memcpy(y, a.parameters[0].data() + code * width,
                  width * sizeof(float));
    } else {
      for (int64_t i = 0; i < width; ++i) y[i] = kNan;
    }
  }
}

void WeightedSum(const StepArguments& a) {
  const int64_t stride = a.output().stride;
  for (int64_t r = 0; r < a.batch; ++r) {
    const float* weights = a.input(0).row(r);
    float* y = a.output().row(r);
    for (int64_t i = 0; i < stride; i += kLanes) {
      Float8 sum = Splat(0.0f);
      for (int64_t e = 0; e < a.input(0).width; ++e) {
        sum = Fma(Splat(weights[e]), Load(a.input(e + 1).row(r) + i), sum);
      }
      Store(y + i, sum);
    }
  }
}

void Concat(const StepArguments& a) {
  for (int64_t r = 0; r < a.batch; ++r) {
    float* y = a.output().row(r);
    for (size_t i = 0; i < a.step.inputs.size(); ++i) {
      const int64_t width = a.input(i).width;
      std::memcpy(y, a.input(i).row(r), width * sizeof(float));
      y += width;
    }
  }
}

void Slice(const StepArguments& a) {
  for (int64_t r = 0; r < a.batch; ++r) {
    std::memcpy(a.output().row(r), a.input(0).row(r) + a.step.begin,
                a.output().width * sizeof(float));
  }
}

}  // namespace

void RunStep(const StepArguments& a) {
  if (IsElementOp(a.step.op)) return RunElementOp(a);
  switch (a.step.op) {
    case v1::OP_LINEAR:
      return RunLinear(a);
    case v1::OP_CONV1D:
    case v1::OP_CONV1D_TRANSPOSE:
      return RunConvolution(a);
    case v1::OP_LAYER_NORM:
      return LayerNorm(a);
    case v1::OP_SOFTMAX:
      return Softmax(a);
    case v1::OP_CONCAT:
      return Concat(a);
    case v1::OP_SLICE:
      return Slice(a);
    case v1::OP_L2_NORMALISE:
      return L2Normalise(a);
    case v1::OP_ARGMIN:
      return Argmin(a);
    case v1::OP_GATHER:
      return Gather(a);
    case v1::OP_WEIGHTED_SUM:
      return WeightedSum(a);
    default:
      SINEW_CHECK(false) << v1::Op_Name(a.step.op);
  }
}

}  // namespace sinew::policy::internal
