// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/hash.h"

#include "ndg/core/error.h"
#include "ndg/core/text_file.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <vector>

namespace ndg {
namespace {

namespace fs = std::filesystem;

class Sha256 {
public:
    Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free)
    {
        require(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1, "cannot start SHA-256");
    }
    void add(const void* data, std::size_t size)
    {
        require(EVP_DigestUpdate(context_.get(), data, size) == 1, "SHA-256 failed");
    }
    std::string hex()
    {
        std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
        unsigned int size = 0;
        require(EVP_DigestFinal_ex(context_.get(), digest.data(), &size) == 1, "SHA-256 failed");
        std::string text;
        for (unsigned int i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
        return text;
    }

private:
    std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

std::string sha256_file(const std::string& path)
{
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
    require_input(file != nullptr, "{}: cannot open: {}", path, std::strerror(errno));
    Sha256 hash;
    std::vector<char> buffer(1 << 20);
    std::size_t count = 0;
    while ((count = std::fread(buffer.data(), 1, buffer.size(), file.get())) > 0) hash.add(buffer.data(), count);
    require_input(std::ferror(file.get()) == 0, "{}: cannot read: {}", path, std::strerror(errno));
    return hash.hex();
}

}  // namespace

std::string sha256(std::string_view bytes)
{
    Sha256 hash;
    hash.add(bytes.data(), bytes.size());
    return hash.hex();
}

std::string sha256_path(const std::string& path)
{
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    require_input(fs::exists(status), "{}: does not exist", path);
    if (!fs::is_directory(status)) return sha256_file(path);

    std::vector<std::string> names;
    fs::recursive_directory_iterator entry(path, error);
    require_input(!error, "{}: cannot list: {}", path, error.message());
    for (; entry != fs::recursive_directory_iterator(); entry.increment(error)) {
        // A name that is no text could not be told from another in what is written of it.
        require_input(is_utf8(entry->path().string()), "{}: the name is not UTF-8; rename the file or folder",
                      entry->path().string());
        if (entry->is_regular_file()) names.push_back(entry->path().lexically_relative(path).generic_string());
        require_input(!error, "{}: cannot list: {}", path, error.message());
    }
    require_input(!error, "{}: cannot list: {}", path, error.message());
    std::sort(names.begin(), names.end());
    std::string lines;
    for (const std::string& name : names) lines += sha256_file((fs::path(path) / name).string()) + "  " + name + "\n";
    return sha256(lines);
}

}  // namespace ndg
