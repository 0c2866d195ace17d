// SPDX-License-Identifier: Apache-2.0
// Internal to this module.
#pragma once

#include <ostream>
#include <streambuf>

namespace ndg {

/// Writes to another stream and never says that it failed: libtorch's archives end the process where a write fails, a
/// full disk for one (their destructor throws). Whoever owns the other stream looks at its state afterwards.
class ArchiveBuffer : public std::streambuf {
public:
    explicit ArchiveBuffer(std::ostream& target) : target_(target) {}

protected:
    std::streamsize xsputn(const char* text, std::streamsize count) override
    {
        target_.write(text, count);
        return count;
    }
    int_type overflow(int_type character) override
    {
        if (!traits_type::eq_int_type(character, traits_type::eof())) target_.put(traits_type::to_char_type(character));
        return traits_type::not_eof(character);
    }

private:
    std::ostream& target_;
};

}  // namespace ndg
