#ifndef SINEW_SIM_IMPORT_TESTING_IMPORT_FIXTURE_H_
#define SINEW_SIM_IMPORT_TESTING_IMPORT_FIXTURE_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/files.h"
#include "common/testing/matchers.h"
#include "common/testing/test_files.h"
#include "nlohmann/json.hpp"
#include "sim/character/character.h"
#include "sim/import/clip_report.h"
#include "sim/import/importer.h"
#include "sim/import/testing/made_clips.h"
#include "sim/motion/library.h"

namespace sinew::import::testing {

// What tests of imports share: libraries of the humanoid, in folders of the
// test's own (common/testing/test_files.h).
class ImportFixture : public ::testing::Test {
 protected:
  ImportFixture() {
    auto loaded = character::Character::Load("humanoid", v1::Physics());
    EXPECT_THAT(loaded, sinew::testing::IsOk());
    character_ = *std::move(loaded);
  }

  static nlohmann::json ReportOf(const std::string& library) {
    const auto text =
        ReadFile(JoinPath(sinew::testing::TestPath(library), "report.json"));
    EXPECT_THAT(text, sinew::testing::IsOk());
    return nlohmann::json::parse(*text);
  }
  // Bytes of a library's file.
  static std::string Bytes(const std::string& library,
                           const std::string& name) {
    const auto bytes =
        ReadFile(JoinPath(sinew::testing::TestPath(library), name));
    EXPECT_THAT(bytes, sinew::testing::IsOk());
    return *bytes;
  }
  // Says of each of a library's files when it was written.
  static std::string WriteTimes(const std::string& library) {
    std::string times;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(
             sinew::testing::TestPath(library))) {
      // The lock is opened by every import.
      if (entry.path().filename() == "LOCK") continue;
      absl::StrAppend(&times, entry.path().string(), " ",
                      entry.last_write_time().time_since_epoch().count(), "\n");
    }
    return times;
  }
  // A march that no body could do: it jumps five metres within a frame.
  static std::string JumpingJson() {
    return absl::StrReplaceAll(MarchJson(), {{"0.400000000", "5.400000000"}});
  }
  std::unique_ptr<motion::Library> Import(const std::vector<std::string>& files,
                                          const std::string& name) {
    reports_.clear();
    EXPECT_THAT(ImportFiles(*character_, files, options_,
                            sinew::testing::TestPath(name), &reports_),
                sinew::testing::IsOk());
    auto library = motion::Library::Load(sinew::testing::TestPath(name));
    EXPECT_THAT(library, sinew::testing::IsOk());
    return *std::move(library);
  }

  std::unique_ptr<const character::Character> character_;
  ImportOptions options_;
  std::vector<ClipReport> reports_;
};

}  // namespace sinew::import::testing

#endif  // SINEW_SIM_IMPORT_TESTING_IMPORT_FIXTURE_H_
