// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/credits.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <zlib.h>

#include <cstdint>

namespace ndg {

namespace {

/// As PNG stores numbers.
std::string big_endian(std::uint32_t number)
{
    std::string bytes;
    for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<char>((number >> shift) & 0xff));
    return bytes;
}

}  // namespace

void add_png_credits(const std::string& path, const std::string& credits)
{
    if (credits.empty()) return;
    const std::string signature = "\x89PNG\r\n\x1a\n";
    // The first chunk has 13 bytes, and 12 of length, name and checksum.
    constexpr std::size_t after_header = 8 + 13 + 12;
    std::string content = read_file(path);
    require(content.size() > after_header && content.compare(0, signature.size(), signature) == 0, "{}: is no PNG",
            path);
    std::string chunk = "iTXtCopyright";
    chunk.append(5, '\0');  // end of the keyword, not packed, two; no language, no translated keyword
    chunk += credits;
    const auto checksum = crc32(0, reinterpret_cast<const Bytef*>(chunk.data()), static_cast<uInt>(chunk.size()));
    content.insert(after_header, big_endian(static_cast<std::uint32_t>(chunk.size() - 4)) + chunk +
                                     big_endian(static_cast<std::uint32_t>(checksum)));
    write_file(path, content);
}

void write_credits_beside(const std::string& path, const std::string& credits)
{
    if (credits.empty()) return;
    std::string name = path;
    const std::size_t begin = name.find('{'), end = name.find('}', begin);
    if (begin != std::string::npos && end != std::string::npos) name.erase(begin, end - begin + 1);
    write_file(name + ".licences.txt", credits + "\n");
}

}  // namespace ndg
