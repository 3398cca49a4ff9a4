#include "segserve/server/server_info.hpp"

#include <optional>
#include <string>

#include "segserve/server/version.hpp"
#include "segserve/wire/limits.hpp"
#include "segserve/wire/options.hpp"

namespace segserve::server {
namespace {

/// The value of a numeric field by its name; nullopt if it is not set.
std::optional<double> value_of(const v1alpha1::SegmentOptions& options, const std::string& name) {
  const google::protobuf::FieldDescriptor* field = options.GetDescriptor()->FindFieldByName(name);
  const google::protobuf::Reflection* reflection = options.GetReflection();
  if (field == nullptr || !reflection->HasField(options, field)) return std::nullopt;
  return field->cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_UINT32 ? reflection->GetUInt32(options, field)
                                                                                : reflection->GetDouble(options, field);
}

}  // namespace

v1alpha1::GetServerInfoResponse server_info(const ServerOptions& options, std::size_t workers) {
  v1alpha1::GetServerInfoResponse info;
  info.set_version(kVersion);
  info.add_payload_kinds(v1alpha1::PAYLOAD_KIND_PLANAR);
  info.add_payload_kinds(v1alpha1::PAYLOAD_KIND_PCD_FILE);
  info.add_compressions(v1alpha1::COMPRESSION_NONE);
  info.add_compressions(v1alpha1::COMPRESSION_ZSTD);

  v1alpha1::Limits& limits = *info.mutable_limits();
  limits.set_max_message_bytes(wire::kMaxRequestBytes);
  limits.set_max_points(options.max_points);
  limits.set_max_decoded_bytes(options.max_decoded_bytes);
  limits.set_max_threads(options.threads);
  limits.set_workers(static_cast<std::uint32_t>(workers));
  limits.set_max_queue(static_cast<std::uint32_t>(options.queue));

  *info.mutable_default_options() = wire::to_message(options.defaults);
  for (const Method method : all_methods()) {
    v1alpha1::MethodInfo& entry = *info.add_methods();
    entry.set_method(wire::to_message(method));
    entry.set_name(std::string(name(method)));
    entry.set_default_threshold(default_threshold(method));
  }
  for (const OptionInfo& option : option_table()) {
    v1alpha1::OptionInfo& entry = *info.add_options();
    entry.set_name(std::string(option.name));
    entry.set_unit(std::string(option.unit));
    entry.set_description(std::string(option.description));
    entry.set_minimum(option.minimum);
    entry.set_maximum(option.maximum);
    if (const auto value = value_of(info.default_options(), entry.name())) entry.set_default_value(*value);
  }
  return info;
}

}  // namespace segserve::server
