// SPDX-License-Identifier: Apache-2.0
#include "client/load_test/raw_stream.hpp"

#include <algorithm>

#include "client/calls/connected_channels.hpp"
#include "client/calls/payload_data.hpp"
#include "proto/wire/byte_run.hpp"

namespace segserve::bench {

RawStream::RawStream(const client::ClientOptions& options, std::chrono::milliseconds timeout) {
  context_.set_deadline(std::chrono::system_clock::now() + timeout);
  auto channels = client::make_channels(options);
  if (channels.ok()) channels_ = *std::move(channels);
}

RawStream::~RawStream() {
  if (!call_) return;
  context_.TryCancel();
  call_->Finish();
}

bool RawStream::open(const std::string& client_name) {
  if (!channels_) return false;
  const auto until = client::Clock::now() + std::chrono::seconds(5);
  const client::ServerList list = channels_->fleet().wait_for_servers(until, false);
  if (list.servers.empty()) return false;
  channels_->authorize(context_);
  call_ = v1::SegmentationService::Stub(channels_->get(list.servers.front())).SegmentStream(&context_);
  v1::SegmentStreamRequest request;
  request.mutable_open()->set_client_name(client_name);
  request.mutable_open()->mutable_outputs()->set_labels(true);
  return call_->Write(request) && call_->Read(&opened_) && opened_.has_opened();
}

bool RawStream::send_frame(const client::Payload& payload, std::uint64_t left_out) {
  const client::PayloadData& data = payload.data();
  v1::SegmentStreamRequest request;
  v1::FrameHeader& header = *request.mutable_frame();
  header.set_sequence(++sequence_);
  *header.mutable_cloud() = data.header;
  header.set_encoded_bytes(payload.bytes());
  header.set_points(payload.points());
  header.set_decoded_bytes(payload.decoded_bytes());
  header.set_crc32(data.run->crc32());
  if (!call_->Write(request)) return false;
  wire::OutgoingBytes bytes(data.run);
  const std::uint64_t asked = opened_.opened().max_chunk_bytes();
  const std::uint64_t most = asked == 0 ? wire::kMaxChunkBytes : asked;
  std::uint64_t missing = payload.bytes() - std::min(left_out, payload.bytes());
  while (missing > 0 && !bytes.done()) {
    const std::string_view chunk = bytes.next(static_cast<std::size_t>(std::min(missing, most)));
    request.mutable_chunk()->set_sequence(sequence_);
    request.mutable_chunk()->set_data(std::string(chunk));
    if (!call_->Write(request)) return false;
    missing -= chunk.size();
  }
  return true;
}

bool RawStream::read() {
  v1::SegmentStreamResponse response;
  return call_->Read(&response);
}

}  // namespace segserve::bench
