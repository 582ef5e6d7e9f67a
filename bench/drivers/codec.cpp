// Time to encode and decode one message of each device.

#include <benchmark/benchmark.h>

#include <vector>

#include "drivers/dsa/codec/frame.h"
#include "drivers/dsa/codec/packet.h"
#include "drivers/ft300/codec/measurement.h"
#include "drivers/pg70/codec/can_framing.h"
#include "drivers/pg70/codec/request.h"
#include "drivers/pg70/codec/response.h"

namespace {

using namespace prehend::drivers;

void pg70_state_to_frames(benchmark::State& state) {
  const pg70::Response full = pg70::State{14.5F, 3.2F, 0.45F, 0x03, 0};
  for (auto _ : state) {
    pg70::split_into_frames(0x70C, pg70::encode(full),
                            [](const CanFrame& frame) { benchmark::DoNotOptimize(frame); });
  }
}
BENCHMARK(pg70_state_to_frames);

void pg70_state_from_frames(benchmark::State& state) {
  std::vector<CanFrame> frames;
  const pg70::Response full = pg70::State{14.5F, 3.2F, 0.45F, 0x03, 0};
  pg70::split_into_frames(0x70C, pg70::encode(full),
                          [&](const CanFrame& frame) { frames.push_back(frame); });
  pg70::FrameAssembler assembler;
  for (auto _ : state) {
    for (const CanFrame& frame : frames) {
      if (const auto content = assembler.add(frame)) {
        benchmark::DoNotOptimize(pg70::decode_response(*content, pg70::kWithAll));
      }
    }
  }
}
BENCHMARK(pg70_state_from_frames);

void pg70_move_to_frames(benchmark::State& state) {
  const pg70::Move move{
      .command = pg70::Command::kMovePosition, .count = 4, .values = {34, 20, 320, 1.5F}};
  for (auto _ : state) {
    pg70::split_into_frames(0x50C, pg70::encode(move),
                            [](const CanFrame& frame) { benchmark::DoNotOptimize(frame); });
  }
}
BENCHMARK(pg70_move_to_frames);

// Six pads; on one of them a print of 40 texels.
dsa::Frame six_pads() {
  dsa::Frame frame{1000, std::vector<std::uint16_t>(486)};
  for (std::size_t i = 0; i < 40; ++i) frame.texels[100 + i] = static_cast<std::uint16_t>(30 * i);
  return frame;
}

void dsa_frame_to_bytes(benchmark::State& state) {
  const bool run_length = state.range(0) == 1;
  const dsa::Frame frame = six_pads();
  for (auto _ : state) {
    benchmark::DoNotOptimize(dsa::encode_packet(0, dsa::encode_frame(frame, run_length)));
  }
}
BENCHMARK(dsa_frame_to_bytes)->ArgName("run_length")->Arg(1)->Arg(0);

void dsa_frame_from_bytes(benchmark::State& state) {
  const bool run_length = state.range(0) == 1;
  const auto bytes = dsa::encode_packet(0, dsa::encode_frame(six_pads(), run_length));
  dsa::PacketDecoder decoder;
  dsa::Frame frame;
  for (auto _ : state) {
    decoder.add(bytes);
    const auto packet = decoder.next();
    if (!packet || !dsa::decode_frame(packet->payload, 486, frame)) {
      return state.SkipWithError("not decoded");
    }
    benchmark::DoNotOptimize(frame);
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes.size()));
}
BENCHMARK(dsa_frame_from_bytes)->ArgName("run_length")->Arg(1)->Arg(0);

void ft300_message_from_bytes(benchmark::State& state) {
  const auto bytes = ft300::encode_stream({{12.34, -5.67, 25}, {-0.012, 0.345, -0.678}});
  ft300::StreamDecoder decoder;
  for (auto _ : state) {
    decoder.add(bytes);
    benchmark::DoNotOptimize(decoder.next());
  }
}
BENCHMARK(ft300_message_from_bytes);

}  // namespace
