// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/server_info.hpp"

#include <chrono>
#include <optional>
#include <string>

#include "proto/wire/codec_message.hpp"
#include "proto/wire/options_message.hpp"
#include "proto/wire/transport_limits.hpp"
#include "server/frames/frame_resolver.hpp"
#include "server/version.hpp"

namespace segserve::server {

v1::GetServerInfoResponse server_info(const ServerOptions& options, std::size_t workers) {
  v1::GetServerInfoResponse info;
  info.set_version(kVersion);
  for (const v1::PayloadKind kind : wire::accepted_kinds(decode_limits(options))) {
    info.add_payload_kinds(kind);
  }
  info.add_compressions(v1::COMPRESSION_NONE);
  info.add_compressions(v1::COMPRESSION_ZSTD);

  v1::Limits& limits = *info.mutable_limits();
  limits.set_max_message_bytes(wire::kMaxRequestBytes);
  limits.set_max_points(options.max_points);
  limits.set_max_decoded_bytes(options.max_decoded_bytes);
  limits.set_max_threads(options.threads);
  limits.set_workers(static_cast<std::uint32_t>(workers));
  limits.set_max_queue(static_cast<std::uint32_t>(options.queue));
  limits.set_max_queue_bytes(options.queue_bytes);
  limits.set_max_queue_points(options.queue_points);
  limits.set_max_voxels(options.max_voxels);
  limits.set_memory_bytes(options.memory);
  limits.set_max_frame_seconds(std::chrono::duration<double>(options.max_frame_time).count());

  const Options defaults = resolved(options.defaults);
  *info.mutable_default_options() = wire::to_message(defaults);
  for (const Method method : all_methods()) {
    v1::MethodInfo& entry = *info.add_methods();
    entry.set_method(wire::to_message(method));
    entry.set_name(std::string(name(method)));
    Options with_method = options.defaults;
    with_method.method = method;
    *entry.mutable_defaults() = wire::to_message(resolved(with_method));
  }
  for (const OptionInfo& option : option_table()) {
    v1::OptionInfo& entry = *info.add_options();
    entry.set_name(std::string(option.name));
    entry.set_unit(std::string(option.unit));
    entry.set_description(std::string(option.description));
    entry.set_minimum(option.minimum);
    entry.set_maximum(option.maximum);
    if (const std::optional<double> value = option.get(defaults)) entry.set_default_value(*value);
  }
  return info;
}

}  // namespace segserve::server
