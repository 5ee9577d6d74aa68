#ifndef SINEW_COMMON_POLICY_LATENT_GRAPHS_H_
#define SINEW_COMMON_POLICY_LATENT_GRAPHS_H_

namespace sinew::policy {

// Names of the graphs that a policy with a latent has beside "policy"
// (common/policy/latent_builder.h).
inline constexpr char kEncoderGraph[] = "encoder";
inline constexpr char kPriorGraph[] = "prior";
inline constexpr char kDecoderGraph[] = "decoder";
inline constexpr char kSampleGraph[] = "sample";

}  // namespace sinew::policy

#endif  // SINEW_COMMON_POLICY_LATENT_GRAPHS_H_
