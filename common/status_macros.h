#ifndef SINEW_COMMON_STATUS_MACROS_H_
#define SINEW_COMMON_STATUS_MACROS_H_

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

// Early returns for functions that return absl::Status or absl::StatusOr<T>.
//
//   SINEW_RETURN_IF_ERROR(MakeDirectories(folder));
//   SINEW_ASSIGN_OR_RETURN(std::string bytes, ReadFile(path));
//   SINEW_ASSIGN_OR_RETURN((std::map<int, int> table), MakeTable());
//
// SINEW_ASSIGN_OR_RETURN declares variables, so it is a statement of a block,
// never the body of an unbraced `if`. A type with a comma goes in parentheses.

// Evaluates `expression` once; returns its status from the enclosing function
// unless it is OK.
#define SINEW_RETURN_IF_ERROR(expression)                  \
  do {                                                     \
    absl::Status sinew_status_macro_status = (expression); \
    if (!sinew_status_macro_status.ok()) {                 \
      return sinew_status_macro_status;                    \
    }                                                      \
  } while (false)

// Evaluates `expression` (an absl::StatusOr) once; returns its status unless it
// is OK, else moves the value into `declaration`.
#define SINEW_ASSIGN_OR_RETURN(declaration, expression)               \
  SINEW_INTERNAL_ASSIGN_OR_RETURN(                                    \
      SINEW_INTERNAL_CONCAT(sinew_status_or_, __LINE__), declaration, \
      expression)

#define SINEW_INTERNAL_ASSIGN_OR_RETURN(result, declaration, expression) \
  auto result = (expression);                                            \
  if (!result.ok()) {                                                    \
    return std::move(result).status();                                   \
  }                                                                      \
  SINEW_INTERNAL_UNPARENTHESISE(declaration) = *std::move(result)

#define SINEW_INTERNAL_CONCAT_INNER(a, b) a##b
#define SINEW_INTERNAL_CONCAT(a, b) SINEW_INTERNAL_CONCAT_INNER(a, b)

// (std::map<int, int> x) becomes std::map<int, int> x; everything else stays.
#define SINEW_INTERNAL_UNPARENTHESISE(x) \
  SINEW_INTERNAL_STRIP_VANISH(SINEW_INTERNAL_STRIP_MARK x)
#define SINEW_INTERNAL_STRIP_MARK(...) SINEW_INTERNAL_STRIP_MARK __VA_ARGS__
#define SINEW_INTERNAL_STRIP_VANISH(...) SINEW_INTERNAL_STRIP_PASTE(__VA_ARGS__)
#define SINEW_INTERNAL_STRIP_PASTE(...) SINEW_INTERNAL_VANISH_##__VA_ARGS__
#define SINEW_INTERNAL_VANISH_SINEW_INTERNAL_STRIP_MARK

#endif  // SINEW_COMMON_STATUS_MACROS_H_
