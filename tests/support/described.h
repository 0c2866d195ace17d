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
    // Only padding is cleared: what is left of the ones belongs to fields.
    union Storage {
        Storage() { std::memset(static_cast<void*>(this), 0xff, sizeof(*this)); }
        ~Storage() {}
        Options options;
    } fields;
    __builtin_clear_padding(&fields.options);
    std::vector<unsigned char> open(sizeof(Options));
    std::memcpy(open.data(), static_cast<const void*>(&fields.options), sizeof(Options));

    Options options;
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
