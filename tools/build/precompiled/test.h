// What tests include besides.
#ifndef SINEW_TOOLS_BUILD_PRECOMPILED_TEST_H_
#define SINEW_TOOLS_BUILD_PRECOMPILED_TEST_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#endif  // SINEW_TOOLS_BUILD_PRECOMPILED_TEST_H_
