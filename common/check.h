#ifndef SINEW_COMMON_CHECK_H_
#define SINEW_COMMON_CHECK_H_

#include <ostream>
#include <sstream>

// Assertions about our own code. What the outside can cause (peers, files,
// configuration, data) is an absl::Status instead.
//
//   SINEW_CHECK(rows > 0) << "rows " << rows;
//
// A failed check prints "file:line: check failed: condition: message" to
// stderr and aborts. Debug checks vanish with NDEBUG (--config=opt): their
// condition is compiled but not evaluated, so hot loops may have them.
//
// Thread-safety: any thread. Blocking: only while printing the last words.

// Aborts unless `condition` holds; streamed operands are evaluated only then.
#define SINEW_CHECK(condition)                                              \
  __builtin_expect(static_cast<bool>(condition), true)                      \
      ? static_cast<void>(0)                                                \
      : ::sinew::internal::Voidify() &                                      \
            ::sinew::internal::CheckFailure(__FILE__, __LINE__, #condition) \
                .stream()

#ifdef NDEBUG
#define SINEW_DCHECK(condition) SINEW_CHECK(true || (condition))
#else
#define SINEW_DCHECK(condition) SINEW_CHECK(condition)
#endif

namespace sinew::internal {

// Collects the message; aborts when the full expression ends.
class CheckFailure {
 public:
  CheckFailure(const char* file, int line, const char* condition);
  CheckFailure(const CheckFailure&) = delete;
  CheckFailure& operator=(const CheckFailure&) = delete;
  [[noreturn]] ~CheckFailure();

  std::ostream& stream() { return stream_; }

 private:
  std::ostringstream stream_;
};

// Gives the streamed expression the type void; & binds looser than <<.
struct Voidify {
  void operator&(std::ostream&) const {}
};

}  // namespace sinew::internal

#endif  // SINEW_COMMON_CHECK_H_
