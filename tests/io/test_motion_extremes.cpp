// SPDX-License-Identifier: Apache-2.0
// Motion files at the edges: one frame, very many, names in other scripts, files that are cut or no text at all.
#include "ndg/core/error.h"
#include "ndg/io/motion.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

const std::string hierarchy =
    "HIERARCHY\nROOT H\xC3\xBC"
    "fte\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
    "Yrotation\nJOINT \xE8\x86\x9D\n{\nOFFSET 0 -4 0\nCHANNELS 3 Zrotation Xrotation "
    "Yrotation\nEnd Site\n{\nOFFSET 0 -4 0\n}\n}\n}\n";
const std::string asf =
    ":units\n length 0.45\n angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n position 0 0 0\n orientation 0 0 "
    "0\n:bonedata\n begin\n id 1\n name \xD0\xB1\xD0\xB5\xD0\xB4\xD1\x80\xD0\xBE\n direction 0 -1 0\n length 4\n axis "
    "0 0 0 XYZ\n dof rx\n limits (-10 10)\n end\n:hierarchy\n begin\n root "
    "\xD0\xB1\xD0\xB5\xD0\xB4\xD1\x80\xD0\xBE\n end\n";

void write(const std::string& path, const std::string& content)
{
    std::ofstream(path, std::ios::binary) << content;
}

std::string motion(int num_frames)
{
    std::string text = "MOTION\nFrames: " + std::to_string(num_frames) + "\nFrame Time: 0.01\n";
    for (int f = 0; f < num_frames; ++f) text += "0 1 0 0 0 0 0 " + std::to_string(f % 90) + " 0\n";
    return text;
}

}  // namespace

TEST_CASE("files and joints may have names in any script, with or without a byte order mark")
{
    const test::TemporaryFolder folder;
    const std::string name = folder.file("\xE6\xAD\xA9\xE3\x81\x8F caf\xC3\xA9.bvh");
    for (const std::string mark : {"", "\xEF\xBB\xBF"}) {
        write(name, mark + hierarchy + motion(1));
        const MotionClip clip = read_bvh(name);
        CHECK(clip.name == "\xE6\xAD\xA9\xE3\x81\x8F caf\xC3\xA9");
        CHECK(clip.find_joint("\xE8\x86\x9D") == 1);
        CHECK(clip.num_frames() == 1);
    }
    write(folder.file("\xD0\xB0.asf"), asf);
    write(folder.file("\xD0\xB0.amc"),
          ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 1 0 0 0 0\n"
          "\xD0\xB1\xD0\xB5\xD0\xB4\xD1\x80\xD0\xBE 30\n");
    const MotionClip clip = read_asf_amc(folder.file("\xD0\xB0.asf"), folder.file("\xD0\xB0.amc"));
    CHECK(clip.name == "\xD0\xB0");
    CHECK(clip.find_joint("\xD0\xB1\xD0\xB5\xD0\xB4\xD1\x80\xD0\xBE") == 1);
    CHECK(clip.num_frames() == 1);
}

TEST_CASE("two hundred thousand frames are read whole, in seconds")
{
    const test::TemporaryFolder folder;
    constexpr int count = 200000;
    write(folder.file("long.bvh"), hierarchy + motion(count));
    const auto begin = std::chrono::steady_clock::now();
    const MotionClip clip = read_bvh(folder.file("long.bvh"));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    REQUIRE(clip.num_frames() == count);
    CHECK(clip.root_positions.rows() == count);
    const double angle = (count - 1) % 90 * M_PI / 180.0;
    CHECK(clip.world_from_joint.back()[1](2, 1) == Approx(std::sin(angle)));
    CHECK(seconds < 15.0);

    std::string amc = ":FULLY-SPECIFIED\n:DEGREES\n";
    for (int f = 1; f <= count; ++f) {
        amc += std::to_string(f) + "\nroot 0 1 0 0 0 0\n\xD0\xB1\xD0\xB5\xD0\xB4\xD1\x80\xD0\xBE 30\n";
    }
    write(folder.file("a.asf"), asf);
    write(folder.file("a.amc"), amc);
    CHECK(read_asf_amc(folder.file("a.asf"), folder.file("a.amc")).num_frames() == count);
}

TEST_CASE("a file cut anywhere is refused in one sentence, or is whole")
{
    const test::TemporaryFolder folder;
    const std::string whole = hierarchy + motion(3);
    const std::string path = folder.file("cut.bvh");
    int num_refused = 0;
    for (std::size_t length = 0; length < whole.size(); length += 3) {
        write(path, whole.substr(0, length));
        try {
            // Only the last number can lose digits without anyone seeing it.
            const MotionClip clip = read_bvh(path);
            CHECK(clip.num_frames() == 3);
            CHECK(length + 4 > whole.size());
        } catch (const InputError& error) {
            ++num_refused;
            const std::string message = error.what();
            CHECK_THAT(message, Contains(path));
            CHECK(message.find('\n') == std::string::npos);
        }
    }
    CHECK(num_refused > 90);
}

TEST_CASE("a file that is no text is refused in one printable sentence")
{
    const test::TemporaryFolder folder;
    std::string bytes;
    for (int k = 0; k < 5000; ++k)
        bytes += static_cast<char>((k * 7 + k / 11) % 256 == ' ' ? 1 : (k * 7 + k / 11) % 31);
    for (const char* name : {"x.bvh", "x.asf"}) write(folder.file(name), bytes);
    const auto check = [&](const std::function<void()>& read) {
        try {
            read();
            FAIL("it was read");
        } catch (const InputError& error) {
            const std::string message = error.what();
            CHECK(message.size() < 600);
            for (const char c : message) CHECK(static_cast<unsigned char>(c) >= 0x20);
        }
    };
    check([&] { read_bvh(folder.file("x.bvh")); });
    write(folder.file("x.amc"), "1\n");
    check([&] { read_asf_amc(folder.file("x.asf"), folder.file("x.amc")); });
    check([&] { read_bvh(folder.path()); });
}
