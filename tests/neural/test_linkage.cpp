// SPDX-License-Identifier: Apache-2.0
// What libtorch must not replace in our programs.
#include <catch2/catch.hpp>

#include <dlfcn.h>

#include <filesystem>
#include <string>

TEST_CASE("std::filesystem is the system's, not a part of libtorch")
{
    using RemoveAll = std::uintmax_t (*)(const std::filesystem::path&);
    const RemoveAll remove_all = &std::filesystem::remove_all;
    Dl_info found{};
    REQUIRE(dladdr(reinterpret_cast<const void*>(remove_all), &found) != 0);
    CHECK(std::string(found.dli_fname).find("libstdc++") != std::string::npos);
}
