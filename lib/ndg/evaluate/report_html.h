// SPDX-License-Identifier: Apache-2.0
// Parts of a report as one file of HTML that needs no other.
#pragma once

#include <string>
#include <vector>

namespace ndg {

/// A table of texts whose first row is its head.
std::string html_table(const std::vector<std::vector<std::string>>& table);
/// A PNG file's bytes.
std::string html_picture(const std::string& png, const std::string& name);
/// Content that is HTML with a caption that is text; nothing without content.
std::string html_figure(const std::string& content, const std::string& caption);
/// The whole page around its body.
std::string html_report(const std::string& title, const std::string& body);

}  // namespace ndg
