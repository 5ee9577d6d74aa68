#include "tools/training/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace sinew::tools {
namespace {

constexpr int kBarWidth = 24;
constexpr char kErase[] = "\r\033[K";

std::string Bar(double share, int width) {
  const int full = static_cast<int>(std::lround(share * width));
  return absl::StrCat("[", std::string(full, '#'),
                      std::string(width - full, '.'), "]",
                      absl::StrFormat(" %3.0f %%", 100 * share));
}

void WriteToStderr(absl::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

std::string TimeText(double seconds) {
  const int64_t whole = std::llround(std::max(0.0, seconds));
  if (whole >= 3600) {
    return absl::StrFormat("%d:%02d:%02d", whole / 3600, whole / 60 % 60,
                           whole % 60);
  }
  return absl::StrFormat("%d:%02d", whole / 60, whole % 60);
}

std::string ProgressText(const ProgressState& state, int bar_width) {
  std::string text;
  if (state.share) {
    text =
        absl::StrCat(Bar(std::clamp(*state.share, 0.0, 1.0), bar_width), "  ");
  }
  absl::StrAppendFormat(
      &text, "iteration %d  %.2f M samples  %.1f k/s  ", state.iteration,
      static_cast<double>(state.samples) / 1e6, state.samples_per_second / 1e3);
  absl::StrAppendFormat(&text, "reward %.3f", state.reward);
  if (state.action_error_rad) {
    absl::StrAppendFormat(&text, "  error %.3f rad", *state.action_error_rad);
  }
  if (!state.evaluation.empty()) absl::StrAppend(&text, "  ", state.evaluation);
  if (state.seconds_left) {
    absl::StrAppend(&text, "  ", TimeText(*state.seconds_left), " left");
  }
  if (!state.trouble.empty()) absl::StrAppend(&text, "  ! ", state.trouble);
  return text;
}

Progress::Progress(Options options, const Clock& clock)
    : options_([&] {
        if (!options.write) options.write = WriteToStderr;
        return std::move(options);
      }()),
      clock_(clock) {}

Progress::~Progress() {
  MutexLock lock(mu_);
  if (!bar_.empty()) options_.write("\n");
}

void Progress::Show(const ProgressState& state) {
  ShowText(ProgressText(state, kBarWidth));
}

void Progress::Show(double share, absl::string_view text) {
  ShowText(
      absl::StrCat(Bar(std::clamp(share, 0.0, 1.0), kBarWidth), "  ", text));
}

void Progress::ShowText(std::string text) {
  MutexLock lock(mu_);
  if (options_.is_terminal) {
    bar_ = std::move(text);
    options_.write(absl::StrCat(kErase, bar_));
    return;
  }
  const Clock::TimePoint now = clock_.SteadyNow();
  if (now < next_) return;
  next_ = clock_.After(options_.period);
  options_.write(absl::StrCat(text, "\n"));
}

void Progress::Line(absl::string_view text) {
  MutexLock lock(mu_);
  if (bar_.empty()) {
    options_.write(absl::StrCat(text, "\n"));
  } else {
    options_.write(absl::StrCat(kErase, text, "\n", bar_));
  }
}

}  // namespace sinew::tools
