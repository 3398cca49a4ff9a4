// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "server/http/multipart.hpp"
#include "server/http/request_query.hpp"
#include "server/options/host_name.hpp"

namespace segserve::server {
namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

/// A form as it comes: the first line is the type of its content.
void read_form(std::string_view text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view body = text.substr(std::min(end + 1, text.size()));
  const auto parts = parse_form(text.substr(0, end), body);
  if (!parts.ok()) return;
  require(parts->size() <= 16);
  for (const FormPart& part : *parts) {
    require(part.content.data() >= body.data());
    require(part.content.data() + part.content.size() <= body.data() + body.size());
  }
}

/// A form that is put together around any bytes gives them back.
void read_own_form(std::string_view content) {
  if (content.find("\r\n--boundary") != std::string_view::npos) return;
  std::string body = "--boundary\r\nContent-Disposition: form-data; name=\"depth\"\r\n\r\n";
  body.append(content).append("\r\n--boundary--\r\n");
  const auto parts = parse_form("multipart/form-data; boundary=boundary", body);
  require(parts.ok() && parts->size() == 1 && parts->front().name == "depth" && parts->front().content == content);
}

/// What a query means is the same if it is written with an escape for each byte.
void read_query(std::string_view text) {
  const auto parameters = parse_query(text);
  if (!parameters) return;
  std::string again;
  const auto append_escaped = [&again](const std::string& part) {
    for (const char c : part) again += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  };
  for (const auto& [name, value] : *parameters) {
    again += '&';
    append_escaped(name);
    again += '=';
    append_escaped(value);
  }
  require(parse_query(again) == parameters);
}

/// Only names and addresses of this machine are allowed by themselves.
void read_host(std::string_view text) {
  if (!is_host_allowed(text, {})) return;
  const bool is_name = text.size() >= 9 && (text[0] == 'l' || text[0] == 'L');
  require(is_name || text.starts_with("127.") || text.starts_with('['));
  require(text.find_first_of("/@ \t\r\n,\0") == std::string_view::npos);
  if (const auto names = parse_host_names(text); names.ok()) require(names->size() == 1);
}

}  // namespace
}  // namespace segserve::server

// What the web entrance reads itself: forms, queries and names of hosts. The first byte says which.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace segserve::server;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      read_form(text);
      break;
    case 1:
      read_own_form(text);
      break;
    case 2:
      read_query(text);
      break;
    default:
      read_host(text);
      break;
  }
  return 0;
}
