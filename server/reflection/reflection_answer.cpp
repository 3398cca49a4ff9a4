// SPDX-License-Identifier: Apache-2.0
#include "server/reflection/reflection_answer.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "google/protobuf/descriptor.h"
#include "google/protobuf/descriptor.pb.h"
#include "google/protobuf/message.h"
#include "grpc/health/v1/health.grpc.pb.h"
#include "grpc/reflection/v1/reflection.grpc.pb.h"
#include "grpc/reflection/v1alpha/reflection.grpc.pb.h"
#include "grpcpp/support/slice.h"
#include "grpcpp/support/status.h"
#include "proto/wire/message_shape.hpp"
#include "segserve/v1/segmentation_service.grpc.pb.h"

namespace segserve::server {
namespace {

namespace reflection = grpc::reflection::v1;
using google::protobuf::DescriptorPool;
using google::protobuf::FileDescriptor;
using Files = std::vector<const FileDescriptor*>;
using Request = reflection::ServerReflectionRequest;

constexpr std::size_t kMostRequestBytes = 4096;

std::array<const char*, 4> services() {
  return {v1::SegmentationService::service_full_name(), grpc::health::v1::Health::service_full_name(),
          reflection::ServerReflection::service_full_name(),
          grpc::reflection::v1alpha::ServerReflection::service_full_name()};
}

/// Adds the file behind those that it imports, unless it is there.
void add_with_imports(const FileDescriptor* file, Files& files) {
  if (std::ranges::find(files, file) != files.end()) return;
  for (int i = 0; i < file->dependency_count(); ++i) add_with_imports(file->dependency(i), files);
  files.push_back(file);
}

/// All files that the services need.
Files visible_files() {
  // Nothing else uses the messages of v1alpha, so that the linker would leave out their file.
  google::protobuf::LinkMessageReflection<grpc::reflection::v1alpha::ServerReflectionRequest>();
  Files files;
  for (const char* service : services()) {
    const auto* descriptor = DescriptorPool::generated_pool()->FindServiceByName(service);
    if (descriptor != nullptr) add_with_imports(descriptor->file(), files);
  }
  return files;
}

/// The file with what it imports, or an error if clients may not see it.
void answer_file(const FileDescriptor* file, const std::string& name, reflection::ServerReflectionResponse& response) {
  const Files visible = visible_files();
  if (file == nullptr || std::ranges::find(visible, file) == visible.end()) {
    response.mutable_error_response()->set_error_code(grpc::StatusCode::NOT_FOUND);
    response.mutable_error_response()->set_error_message(fmt::format("this server has no {}", name));
    return;
  }
  Files files;
  add_with_imports(file, files);
  for (const FileDescriptor* each : files) {
    google::protobuf::FileDescriptorProto message;
    each->CopyTo(&message);
    *response.mutable_file_descriptor_response()->add_file_descriptor_proto() = message.SerializeAsString();
  }
}

/// None of our messages has extensions.
void answer_extensions(const std::string& type, reflection::ServerReflectionResponse& response) {
  const auto* found = DescriptorPool::generated_pool()->FindMessageTypeByName(type);
  if (found == nullptr) return answer_file(nullptr, type, response);
  response.mutable_all_extension_numbers_response()->set_base_type_name(type);
}

reflection::ServerReflectionResponse answer(const Request& request) {
  const DescriptorPool& pool = *DescriptorPool::generated_pool();
  reflection::ServerReflectionResponse response;
  response.set_valid_host(request.host());
  *response.mutable_original_request() = request;
  switch (request.message_request_case()) {
    case Request::kListServices:
      for (const char* service : services()) {
        response.mutable_list_services_response()->add_service()->set_name(service);
      }
      break;
    case Request::kFileByFilename:
      answer_file(pool.FindFileByName(request.file_by_filename()), request.file_by_filename(), response);
      break;
    case Request::kFileContainingSymbol:
      answer_file(pool.FindFileContainingSymbol(request.file_containing_symbol()), request.file_containing_symbol(),
                  response);
      break;
    case Request::kFileContainingExtension:
      answer_file(nullptr, request.file_containing_extension().containing_type(), response);
      break;
    case Request::kAllExtensionNumbersOfType:
      answer_extensions(request.all_extension_numbers_of_type(), response);
      break;
    case Request::MESSAGE_REQUEST_NOT_SET:
      response.mutable_error_response()->set_error_code(grpc::StatusCode::INVALID_ARGUMENT);
      response.mutable_error_response()->set_error_message("the request asks for nothing that this server knows");
      break;
  }
  return response;
}

}  // namespace

absl::StatusOr<grpc::ByteBuffer> answer_reflection(grpc::ByteBuffer& request) {
  if (request.Length() > kMostRequestBytes) {
    request.Clear();
    return absl::InvalidArgumentError(fmt::format("the request has more than {} bytes", kMostRequestBytes));
  }
  Request message;
  RETURN_IF_ERROR(wire::parse_bounded(request, "ServerReflectionRequest", message));
  const grpc::Slice bytes(answer(message).SerializeAsString());
  return grpc::ByteBuffer(&bytes, 1);
}

}  // namespace segserve::server
