// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/markup.h"

namespace ndg {

std::string escaped_markup(const std::string& text)
{
    std::string escaped;
    for (const char c : text) switch (c) {
            case '&':
                escaped += "&amp;";
                break;
            case '<':
                escaped += "&lt;";
                break;
            case '>':
                escaped += "&gt;";
                break;
            case '"':
                escaped += "&quot;";
                break;
            default:
                escaped += c;
        }
    return escaped;
}

}  // namespace ndg
