#ifndef SINEW_SIM_IMPORT_FORMATS_TESTING_NPZ_WRITER_H_
#define SINEW_SIM_IMPORT_FORMATS_TESTING_NPZ_WRITER_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace sinew::import::testing {

// Files as NumPy writes them.

// A header of the format's version 1 and the data after it.
std::string MakeNpy(absl::string_view descr, bool fortran_order,
                    absl::string_view shape, absl::string_view data);

// An array of "<f4", "<f8", ">f4", "<i4" ... in C order; `shape` as Python
// writes it, "(2, 3)".
std::string MakeNpy(absl::string_view descr, absl::string_view shape,
                    const std::vector<double>& values);

// One text, as a 0-d array of Unicode.
std::string MakeNpyText(absl::string_view ascii);

struct NpzMember {
  std::string name;  // without ".npy"
  std::string bytes;
};

// A zip file of NAME.npy members.
std::string MakeNpz(const std::vector<NpzMember>& members,
                    bool deflated = false);

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_FORMATS_TESTING_NPZ_WRITER_H_
