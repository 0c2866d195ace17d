// SPDX-License-Identifier: Apache-2.0
// Whether an options struct is described in full: an option that its describe() forgot would be missing in flags,
// checks and the key of resumable runs alike.
#pragma once

#include "ndg/core/options.h"

#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

namespace ndg::test {

/// Offsets of the bytes that belong to a field but to no option.
template <typename Options>
std::vector<std::size_t> undescribed_bytes()
{
    Options options;
    std::vector<unsigned char> open(sizeof(Options)), kept(sizeof(Options));
    void* const memory = &options;
    std::memcpy(kept.data(), memory, sizeof(Options));
    std::memset(memory, 0xff, sizeof(Options));
    __builtin_clear_padding(&options);  // what is left of the ones belongs to fields
    std::memcpy(open.data(), memory, sizeof(Options));
    std::memcpy(memory, kept.data(), sizeof(Options));

    OptionList list;
    describe(list, options);
    for (const Option& option : list.options()) {
        const auto described = [&](const void* value, std::size_t size) {
            const auto offset = static_cast<const char*>(value) - reinterpret_cast<const char*>(&options);
            for (std::size_t i = 0; i < size; ++i) open[offset + i] = 0;
        };
        std::visit(
            [&](const auto& value) {
                if constexpr (std::is_pointer_v<std::decay_t<decltype(value)>>) {
                    described(value, sizeof(*value));
                } else {
                    described(value.value, value.size);
                }
            },
            option.value);
    }
    std::vector<std::size_t> undescribed;
    for (std::size_t i = 0; i < open.size(); ++i) {
        if (open[i] != 0) undescribed.push_back(i);
    }
    return undescribed;
}

}  // namespace ndg::test
