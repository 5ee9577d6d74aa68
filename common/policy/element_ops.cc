#include "common/policy/element_ops.h"

#include "common/policy/vector_math.h"

namespace sinew::policy::internal {
namespace {

// Applies f to every element. Equal widths have equal strides, so rows need not
// be told apart.
template <typename F>
void Unary(const StepArguments& a, F f) {
  const int64_t size = a.batch * a.output().stride;
  const float* x = a.input(0).data;
  float* y = a.output().data;
  for (int64_t i = 0; i < size; i += kLanes) Store(y + i, f(Load(x + i)));
}

template <typename F>
void Binary(const StepArguments& a, F f) {
  const int64_t size = a.batch * a.output().stride;
  const float* x0 = a.input(0).data;
  const float* x1 = a.input(1).data;
  float* y = a.output().data;
  for (int64_t i = 0; i < size; i += kLanes) {
    Store(y + i, f(Load(x0 + i), Load(x1 + i)));
  }
}

// Applies f to every element and the first `kCount` parameters of its column.
template <typename F>
void ColumnWise(const StepArguments& a, const float* p0, const float* p1, F f) {
  const int64_t stride = a.output().stride;
  for (int64_t r = 0; r < a.batch; ++r) {
    const float* x = a.input(0).row(r);
    float* y = a.output().row(r);
    for (int64_t i = 0; i < stride; i += kLanes) {
      Store(y + i, f(Load(x + i), Load(p0 + i), Load(p1 + i)));
    }
  }
}

void Affine(const StepArguments& a) {
  const float* scale = a.parameters[0].data();
  if (a.step.parameters.size() == 1) {
    ColumnWise(a, scale, scale,
               [](Float8 x, Float8 s, Float8) { return x * s; });
    return;
  }
  ColumnWise(a, scale, a.parameters[1].data(),
             [](Float8 x, Float8 s, Float8 shift) { return Fma(x, s, shift); });
}

void Normalise(const StepArguments& a) {
  ColumnWise(a, a.parameters[0].data(), a.parameters[1].data(),
             [](Float8 x, Float8 mean, Float8 inverse_std) {
               return (x - mean) * inverse_std;
             });
}

void Relu(const StepArguments& a) {
  Unary(a, [](Float8 x) { return x < Splat(0.0f) ? Splat(0.0f) : x; });
}

}  // namespace

bool IsElementOp(v1::Op op) {
  switch (op) {
    case v1::OP_AFFINE:
    case v1::OP_NORMALISE:
    case v1::OP_RELU:
    case v1::OP_ELU:
    case v1::OP_SILU:
    case v1::OP_TANH:
    case v1::OP_SIGMOID:
    case v1::OP_ADD:
    case v1::OP_SUBTRACT:
    case v1::OP_MULTIPLY:
    case v1::OP_CLAMP:
    case v1::OP_EXP:
      return true;
    default:
      return false;
  }
}

void RunElementOp(const StepArguments& a) {
  switch (a.step.op) {
    case v1::OP_AFFINE:
      return Affine(a);
    case v1::OP_NORMALISE:
      return Normalise(a);
    case v1::OP_RELU:
      return Relu(a);
    case v1::OP_ELU:
      return Unary(a, [](Float8 x) { return Elu(x); });
    case v1::OP_SILU:
      return Unary(a, [](Float8 x) { return Silu(x); });
    case v1::OP_TANH:
      return Unary(a, [](Float8 x) { return Tanh(x); });
    case v1::OP_SIGMOID:
      return Unary(a, [](Float8 x) { return Sigmoid(x); });
    case v1::OP_EXP:
      return Unary(a, [](Float8 x) { return Exp(x); });
    case v1::OP_CLAMP:
      return Unary(a, [low = a.step.low, high = a.step.high](Float8 x) {
        return Clamp(x, low, high);
      });
    case v1::OP_ADD:
      return Binary(a, [](Float8 x, Float8 y) { return x + y; });
    case v1::OP_SUBTRACT:
      return Binary(a, [](Float8 x, Float8 y) { return x - y; });
    case v1::OP_MULTIPLY:
      return Binary(a, [](Float8 x, Float8 y) { return x * y; });
    default:
      SINEW_CHECK(false) << v1::Op_Name(a.step.op);
  }
}

}  // namespace sinew::policy::internal
