// SPDX-License-Identifier: Apache-2.0
// Tests how requests of HTTP are read: their queries, forms and messages, good and bad.
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "proto/wire/status_message.hpp"
#include "segserve/v1/segmentation_service.pb.h"
#include "server/http/connect_call.hpp"
#include "server/http/frame_answer.hpp"
#include "server/http/http_error.hpp"
#include "server/http/multipart.hpp"
#include "server/http/request_query.hpp"
#include "server/http/segment_parameters.hpp"
#include "server/scheduling/refusals.hpp"

namespace segserve::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

TEST(RequestQuery, IsDecodedInItsOrder) {
  EXPECT_THAT(*parse_query("a=1&b=%2C+x&&c&a=%C3%A9=2"),
              ElementsAre(Pair("a", "1"), Pair("b", ", x"), Pair("c", ""), Pair("a", "\xC3\xA9=2")));
  EXPECT_TRUE(parse_query("")->empty());
  for (const char* broken : {"a=%", "a=%4", "%zz=1", "a=%-1"}) EXPECT_FALSE(parse_query(broken)) << broken;
}

TEST(Form, HasPartsWithTheBytesBetweenTheirBoundaries) {
  const std::string body =
      "--b\r\nContent-Disposition: form-data; name=\"depth\"; filename=\"a;b\"\r\nContent-Type: "
      "image/png\r\n\r\n\r\n--x\r\n"
      "\r\n--b\r\ncontent-disposition: form-data; name=color\r\n\r\n\r\n--b--\r\n";
  const auto parts = parse_form("multipart/form-data; boundary=\"b\"", body);
  ASSERT_TRUE(parts.ok()) << parts.status();
  ASSERT_EQ(parts->size(), 2U);
  EXPECT_EQ((*parts)[0].name, "depth");
  EXPECT_EQ((*parts)[0].content, "\r\n--x\r\n");
  EXPECT_EQ((*parts)[1].name, "color");
  EXPECT_EQ((*parts)[1].content, "");
}

TEST(Form, ThatIsBrokenIsRefused) {
  const std::string type = "multipart/form-data; boundary=b";
  const std::pair<std::string, const char*> cases[] = {
      {"", "does not begin with its boundary"},
      {"--b", "has a boundary that is not the end of a line"},
      {"--b\r\n\r\nx", "has a part without a name"},
      {"--b\r\nContent-Disposition: form-data; name=\"a\r\n\r\nx\r\n--b--", "has a part without a name"},
      {"--b\r\nContent-Disposition: form-data; name=a\r\n\r\nx", "ends within a part"},
      {"--b\r\n" + std::string(5000, 'x') + "\r\n\r\n", "has a part without an end of its headers"}};
  for (const auto& [body, text] : cases) {
    EXPECT_THAT(std::string(parse_form(type, body).status().message()), HasSubstr(text)) << body;
  }
  EXPECT_FALSE(parse_form("multipart/form-data", "--b--").ok());
  EXPECT_FALSE(parse_form("multipart/form-data; boundary=" + std::string(71, 'b'), "").ok());
  std::string many;
  for (int k = 0; k < 17; ++k) many += "--b\r\nContent-Disposition: form-data; name=a\r\n\r\nx\r\n";
  EXPECT_THAT(std::string(parse_form(type, many + "--b--").status().message()), HasSubstr("has more than 16 parts"));
}

/// The names of the parameters that are told to be wrong.
std::vector<std::string> faults_of(std::string_view query) {
  std::vector<std::string> names;
  for (const FieldViolation& fault : wire::details_of(parse_segment_parameters(query, {}).status()).fields) {
    names.push_back(fault.field);
  }
  return names;
}

TEST(SegmentParameters, SayHowAFileIsSegmented) {
  const auto parameters = parse_segment_parameters(
      "method=lambda-convex&regions=7&voxel_resolution=0.01&outputs=labels,segments&include=1,2&include=0.5,-1,2&"
      "exclude=3,4&larger=-1&view=world:1,2,3&unit=mm&timeout=2.5&request_id=a%20b&name=x.ply",
      {.threshold = 0.3});
  ASSERT_TRUE(parameters.ok()) << parameters.status();
  const Options& options = parameters->request.options;
  EXPECT_EQ(options.method, Method::kLambdaConvex);
  EXPECT_EQ(options.regions, 7U);
  EXPECT_FALSE(options.threshold) << "regions go before the server's threshold";
  EXPECT_EQ(options.voxel_resolution, 0.01);
  EXPECT_EQ(parameters->request.outputs, (wire::Outputs{.labels = true, .segments = true}));
  EXPECT_EQ(*parameters->request.prompts,
            (Prompts{.include = {Pixel{1, 2}, Eigen::Vector3d(0.5, -1, 2)}, .exclude = {Pixel{3, 4}}, .larger = -1}));
  EXPECT_EQ(parameters->read.view, View::world(1, 2, 3));
  EXPECT_EQ(parameters->read.unit, codec::LengthUnit::kMillimeter);
  EXPECT_GE(parameters->timeout, std::chrono::milliseconds(2500));
  EXPECT_EQ(parameters->request_id, "a b");
}

TEST(SegmentParameters, ThatAreWrongAreAllNamed) {
  EXPECT_THAT(
      faults_of("threshold=2&method=x&outputs=labels,x&view=up&unit=km&timeout=0&include=1&nothing=1&intrinsics=1,2"),
      ElementsAre("threshold", "method", "outputs", "view", "unit", "timeout", "include", "nothing", "intrinsics"));
  EXPECT_THAT(faults_of("threshold=0.1&regions=3"), ElementsAre("regions"));
  EXPECT_THAT(faults_of("threshold=0.1&threshold=0.2"), ElementsAre("threshold"));
  EXPECT_THAT(faults_of("threshold=%"), ElementsAre("query"));
  EXPECT_THAT(faults_of("threshold=nan&larger=x"), ElementsAre("threshold", "larger", "include"));
  EXPECT_THAT(faults_of("exclude=1,1"), ElementsAre("include"));
  const auto unknown = parse_segment_parameters("regoins=3&rgb-intrinsics=1&q=1", {});
  EXPECT_THAT(std::string(unknown.status().message()),
              testing::AllOf(HasSubstr("did you mean regions?"), HasSubstr("did you mean rgb_intrinsics?")));
  std::string many;
  for (int k = 0; k < 300; ++k) many += "include=1,1&";
  EXPECT_THAT(faults_of(many), ElementsAre("query"));
}

TEST(Accept, ChoosesTheFormOfTheAnswer) {
  EXPECT_EQ(accepted_form(""), AnswerForm::kJson);
  EXPECT_EQ(accepted_form("*/*"), AnswerForm::kJson);
  EXPECT_EQ(accepted_form("image/png, application/octet-stream;q=0.5"), AnswerForm::kLabels);
  EXPECT_EQ(accepted_form("application/vnd.segserve.view+json"), AnswerForm::kView);
  EXPECT_EQ(accepted_form("image/png"), std::nullopt);
}

TEST(ConnectMessages, HaveNoMemberTwice) {
  const auto fault = [](const std::string& json) {
    v1::SegmentRequest request;
    return std::string(parse_connect(ConnectCodec::kJson, json, "SegmentRequest", request).message());
  };
  EXPECT_EQ(
      fault(R"({"requestId":"a","options":{"lambda":0.5},"prompts":{"include":[{"pixel":{"column":1,"row":2}}]}})"),
      "");
  EXPECT_EQ(fault(R"({"requestId":"a:\"", "cloud":{"width":1,"rgbd":{"depth":{"data":"AA=="}}}})"), "");
  EXPECT_THAT(fault(R"({"options":{"lambda":0.5, "regions":2, "lambda" : 0.6}})"),
              HasSubstr("the SegmentRequest has an object with the member lambda twice"));
  EXPECT_THAT(fault(R"({"prompts":{"include":[{"point":{"x":1,"x":2}}]}})"), HasSubstr("the member x twice"));
  for (const char* broken : {"\"", "{\"", "{\"a", "}]", "{\"a\\", ":", "[\"a\":"})
    EXPECT_NE(fault(broken), "") << broken;
}

TEST(ConnectMessages, InJsonHaveNoFieldThatIsUnknown) {
  const auto fault = [](const std::string& json) {
    v1::SegmentRequest request;
    return std::string(parse_connect(ConnectCodec::kJson, json, "SegmentRequest", request).message());
  };
  EXPECT_THAT(fault(R"({"treshold":0.4})"), HasSubstr("treshold"));
  EXPECT_THAT(fault(R"({"options":{"lamda":0.4}})"), HasSubstr("lamda"));
  EXPECT_THAT(fault(R"({"cloud":{"unit":"FURLONG"}})"), HasSubstr("unit"));
  EXPECT_EQ(fault(R"({"options":{"voxelResolution":0.01,"seed_resolution":0.1}})"), "") << "both spellings of a name";
}

TEST(ConnectMessages, RoundTripInBothCodecs) {
  v1::SegmentRequest request;
  request.set_request_id("\"[{,");
  request.mutable_options()->set_lambda(0.25);
  for (const ConnectCodec codec : {ConnectCodec::kProto, ConnectCodec::kJson}) {
    v1::SegmentRequest read;
    ASSERT_TRUE(parse_connect(codec, connect_answer(codec, request)->body, "SegmentRequest", read).ok());
    EXPECT_EQ(read.SerializeAsString(), request.SerializeAsString());
  }
}

TEST(ConnectMessages, ThatAreBrokenOrHaveTooManyValuesAreRefused) {
  const std::pair<ConnectCodec, std::string> cases[] = {{ConnectCodec::kProto, "\xff\xff"},
                                                        {ConnectCodec::kJson, "{"},
                                                        {ConnectCodec::kJson, ""},
                                                        {ConnectCodec::kJson, "[]"},
                                                        {ConnectCodec::kJson, "\"\\"},
                                                        {ConnectCodec::kJson, std::string(5000, '[')},
                                                        {ConnectCodec::kJson, "{\"prompts\":{\"include\":[{}" + [] {
                                                           std::string text;
                                                           for (int k = 0; k < 5000; ++k) text += ",{}";
                                                           return text;
                                                         }() + "]}}"}};
  for (const auto& [codec, body] : cases) {
    v1::SegmentRequest request;
    const absl::Status status = parse_connect(codec, body, "SegmentRequest", request);
    EXPECT_EQ(wire::details_of(status).reason, wire::ErrorReason::kMalformedPayload) << body.substr(0, 20);
  }
}

TEST(ConnectMessages, AreNotCompressedAndMayHaveADeadline) {
  HttpHead head;
  EXPECT_EQ(*connect_timeout(head), std::nullopt);
  head.headers = {{"connect-timeout-ms", "1500"}};
  EXPECT_EQ(*connect_timeout(head), std::chrono::milliseconds(1500));
  for (const auto& [name, value] : HttpHeaders{{"connect-timeout-ms", "-1"},
                                               {"connect-timeout-ms", "12345678901"},
                                               {"content-encoding", "gzip"},
                                               {"connect-protocol-version", "3"}}) {
    head.headers = {{name, value}};
    EXPECT_FALSE(connect_timeout(head).ok()) << name;
  }
}

TEST(HttpErrors, HaveStatusReasonAndDelay) {
  const HttpAnswer answer = error_answer(draining());
  EXPECT_EQ(answer.status, 503U);
  EXPECT_THAT(answer.body, HasSubstr(R"("reason":"DRAINING")"));
  EXPECT_THAT(answer.headers, testing::Contains(Pair("Retry-After", testing::Ne("0"))));
  EXPECT_EQ(error_answer(wire::limit_exceeded("it has", 2, "bytes", "max_body_bytes", 1)).status, 413U);
  EXPECT_EQ(error_answer(absl::NotFoundError("x")).status, 500U) << "the API has no such error";
  EXPECT_THAT(connect_error_answer(draining()).body, HasSubstr(R"("type":"google.rpc.RetryInfo","value":")"));
}

}  // namespace
}  // namespace segserve::server
