// SPDX-License-Identifier: Apache-2.0
#include <future>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "google/protobuf/descriptor.pb.h"
#include "grpc/reflection/v1/reflection.grpc.pb.h"
#include "grpc/reflection/v1alpha/reflection.grpc.pb.h"
#include "test/server/support/running_server.hpp"

namespace segserve::server {
namespace {

using testing::Contains;
using testing::HasSubstr;

/// A call of reflection by one of its names.
template <typename Interface, typename Request, typename Response>
struct Conversation {
  explicit Conversation(const std::shared_ptr<grpc::Channel>& channel)
      : stub(Interface::NewStub(channel)), stream(stub->ServerReflectionInfo(&context)) {}
  ~Conversation() { context.TryCancel(); }

  Response ask(const Request& request) {
    Response response;
    EXPECT_TRUE(stream->Write(request) && stream->Read(&response));
    return response;
  }
  Response ask_for_symbol(const std::string& symbol) {
    Request request;
    request.set_file_containing_symbol(symbol);
    return ask(request);
  }

  grpc::ClientContext context;
  std::unique_ptr<typename Interface::Stub> stub;
  std::unique_ptr<grpc::ClientReaderWriter<Request, Response>> stream;
};

namespace v1_api = grpc::reflection::v1;
namespace alpha_api = grpc::reflection::v1alpha;
using V1 = Conversation<v1_api::ServerReflection, v1_api::ServerReflectionRequest, v1_api::ServerReflectionResponse>;
using Alpha =
    Conversation<alpha_api::ServerReflection, alpha_api::ServerReflectionRequest, alpha_api::ServerReflectionResponse>;

class Reflection : public testing::Test {
 protected:
  static ServerOptions with_reflection() {
    ServerOptions options = small_server();
    options.reflection = true;
    return options;
  }
  RunningServer server_{with_reflection()};
};

template <typename Talk, typename Request>
std::vector<std::string> services_by(const std::shared_ptr<grpc::Channel>& channel) {
  Talk talk(channel);
  Request request;
  request.set_list_services("*");
  const auto response = talk.ask(request);
  std::vector<std::string> names;
  for (const auto& service : response.list_services_response().service()) names.push_back(service.name());
  return names;
}

TEST_F(Reflection, ListsTheServicesByBothNames) {
  const auto names = services_by<V1, v1_api::ServerReflectionRequest>(server_.channel());
  EXPECT_THAT(names, testing::UnorderedElementsAre("segserve.v1.SegmentationService", "grpc.health.v1.Health",
                                                   "grpc.reflection.v1.ServerReflection",
                                                   "grpc.reflection.v1alpha.ServerReflection"));
  EXPECT_EQ((services_by<Alpha, alpha_api::ServerReflectionRequest>(server_.channel())), names);
}

TEST_F(Reflection, GivesAFileBehindThoseThatItImports) {
  V1 talk(server_.channel());
  std::set<std::string> known;
  const auto response = talk.ask_for_symbol("segserve.v1.SegmentationService.Segment");
  for (const std::string& bytes : response.file_descriptor_response().file_descriptor_proto()) {
    google::protobuf::FileDescriptorProto file;
    ASSERT_TRUE(file.ParseFromString(bytes));
    for (const std::string& import : file.dependency()) EXPECT_TRUE(known.contains(import)) << import;
    known.insert(file.name());
  }
  EXPECT_THAT(known, Contains("segserve/v1/segmentation_service.proto"));
  EXPECT_THAT(known, Contains("google/rpc/status.proto"));

  v1_api::ServerReflectionRequest by_name;
  by_name.set_file_by_filename("grpc/health/v1/health.proto");
  EXPECT_EQ(talk.ask(by_name).file_descriptor_response().file_descriptor_proto_size(), 1);
}

TEST_F(Reflection, HasTheFileOfEveryServiceThatItLists) {
  V1 talk(server_.channel());
  for (const std::string& service : services_by<V1, v1_api::ServerReflectionRequest>(server_.channel())) {
    EXPECT_GT(talk.ask_for_symbol(service).file_descriptor_response().file_descriptor_proto_size(), 0) << service;
  }
}

TEST_F(Reflection, TellsWhatItDoesNotHave) {
  V1 talk(server_.channel());
  v1_api::ServerReflectionRequest request;
  EXPECT_EQ(talk.ask_for_symbol("google.protobuf.FileDescriptorProto").error_response().error_code(),
            grpc::StatusCode::NOT_FOUND)
      << "it is in the process, but in no service";
  EXPECT_THAT(talk.ask_for_symbol("x.Y").error_response().error_message(), HasSubstr("has no x.Y"));
  request.set_all_extension_numbers_of_type("segserve.v1.Cloud");
  EXPECT_EQ(talk.ask(request).all_extension_numbers_response().base_type_name(), "segserve.v1.Cloud");
  request.mutable_file_containing_extension()->set_containing_type("segserve.v1.Cloud");
  EXPECT_EQ(talk.ask(request).error_response().error_code(), grpc::StatusCode::NOT_FOUND);
  request.clear_message_request();
  EXPECT_EQ(talk.ask(request).error_response().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(Reflection, BoundsItsRequestsAndCalls) {
  V1 large(server_.channel());
  v1_api::ServerReflectionRequest request;
  v1_api::ServerReflectionResponse response;
  request.set_file_containing_symbol(std::string(5000, 'x'));
  EXPECT_TRUE(large.stream->Write(request));
  EXPECT_FALSE(large.stream->Read(&response));
  EXPECT_THAT(large.stream->Finish().error_message(), HasSubstr("more than 4096 bytes"));

  std::vector<std::unique_ptr<V1>> calls;
  for (int i = 0; i < 17; ++i) {
    calls.push_back(std::make_unique<V1>(server_.channel()));
    calls.back()->ask_for_symbol("x");
  }
  EXPECT_FALSE(calls.front()->stream->Read(&response));
  EXPECT_EQ(calls.front()->stream->Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  calls.back()->ask_for_symbol("x");
}

TEST_F(Reflection, DoesNotHoldAServerThatStops) {
  V1 talk(server_.channel());
  talk.ask_for_symbol("x");
  EXPECT_TRUE(server_.server().stop());
  v1_api::ServerReflectionResponse response;
  EXPECT_FALSE(talk.stream->Read(&response));
  EXPECT_EQ(talk.stream->Finish().error_message(), "the server stops");
}

TEST(ReflectionOff, IsNotThereUnlessItIsAskedFor) {
  RunningServer server;
  V1 talk(server.channel());
  v1_api::ServerReflectionResponse response;
  EXPECT_FALSE(talk.stream->Read(&response));
  EXPECT_EQ(talk.stream->Finish().error_code(), grpc::StatusCode::UNIMPLEMENTED);
}

}  // namespace
}  // namespace segserve::server
