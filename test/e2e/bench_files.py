# SPDX-License-Identifier: Apache-2.0
"""What segctl bench --json writes, made up: load tests whose latencies are known, for what reads such files."""
import collections
import math

import numpy

STAGES = {"client_encode": 1.2, "client_wait": 0.1, "queue": 2.5, "decode": 0.4, "voxels": 3.1, "normals": 9.5, "supervoxels": 5.2,
          "graph": 1.3, "merging": 2.2, "labels": 0.7, "segments": 0.0, "encode": 0.3, "client_decode": 0.6, "rest": 4.4}
PERCENTS = {"p50": 50, "p90": 90, "p95": 95, "p99": 99, "p99.9": 99.9, "p99.99": 99.99}


def bucket(milliseconds):
    """The highest value, in microseconds, that a histogram of three significant digits does not tell from this one."""
    microseconds = max(1, round(milliseconds * 1000))
    width = 2 ** max(0, microseconds.bit_length() - 11)
    return microseconds // width * width + width - 1


def percentiles(values, failed=0):
    """Percentiles as segctl bench tells them, by the nearest rank: null where they fall among the failed frames."""
    ordered, count = sorted(values), len(values) + failed
    told, beyond = {}, []
    for name, percent in PERCENTS.items():
        rank = max(1, math.ceil(percent / 100 * count - 1e-9)) if count else 0
        told[name] = ordered[rank - 1] if 0 < rank <= len(ordered) else None
        if told[name] is None and count:
            beyond.append(name)
    return told | {"max": max(ordered, default=None), "mean": float(numpy.mean(ordered)) if ordered else None}, beyond


def histogram(values, failed=0):
    counts = collections.Counter(map(bucket, values))
    return {"unit": "us", "significant_digits": 3, "failed": failed, "buckets": [list(pair) for pair in sorted(counts.items())]}


def second(t, values, offered, failed=0):
    told, _ = percentiles(values, failed)
    return {"t": t, "seconds": 1.0, "offered": offered, "sent": len(values) + failed, "results": len(values), "failed": failed, "late": 0,
            "p50_ms": told["p50"], "p90_ms": told["p90"], "p99_ms": told["p99"], "max_ms": told["max"],
            "client_busy_cpus": 0.15, "client_rss_bytes": 60_000_000}


def load_test(latencies, failed=None, warm_up=2, clients=4, **changes):
    """The JSON of an open loop. `latencies` has an array of milliseconds for each measured second, `failed` how many frames failed
    in it."""
    failed = failed or [0] * len(latencies)
    everything = [float(value) for values in latencies for value in values]
    count, lost, seconds = len(everything), sum(failed), len(latencies)
    rate = count / seconds if seconds else 0
    latency, beyond = percentiles(everything, lost)
    since_sent = [0.9 * value for value in everything]
    offered = (count + lost) / seconds if seconds else 0
    timeline = [second(t - warm_up, [30.0] * 10, 10) for t in range(warm_up)]
    timeline += [second(t, [float(v) for v in values], offered, lost_now) for t, (values, lost_now) in
                 enumerate(zip(latencies, failed))]
    stages = STAGES | {"total": sum(STAGES.values())}
    codec = {"codec": "planar", "sent": count + lost, "results": count, "failed": lost, "frames_per_s": rate,
             "mpoints_per_s": rate * 0.3072, "latency_ms": latency, "bytes_up_per_frame": 4_608_100, "bytes_down_per_frame": 307_300,
             "stages_ms": stages, "client_cpu_ms_per_frame": 3.2}
    return {
        "format": "segserve-bench-1", "started": "2026-11-29T15:00:00Z",
        "command": ["segctl", "bench", "--rate", f"{offered:g}", "--clients", str(clients)],
        "host": {"name": "robot-lab", "cpus": 2, "cpu_model": "Example CPU 2.1 GHz", "memory_bytes": 16_000_000_000,
                 "kernel": "Linux 6.1.0", "load_before": 0.12},
        "client_build": {"version": "0.9.0", "compiler": "GNU 12.2.0", "build_type": "Release"},
        "server_info": {"version": "0.9.0", "workers": 2}, "server": "127.0.0.1:50051", "clients": clients, "in_flight": 8, "loop": "open",
        "arrivals": "constant", "speed": None, "offered_frames_per_s": offered, "achieved_frames_per_s": rate, "codec": "planar",
        "encoded_beforehand": False, "seconds": seconds,
        "window": {"warm_up_s": warm_up, "measured_s": seconds, "drain_s": 0.4},
        "frames": {"sent": count + lost, "results": count, "repeated": 0, "hedged": 0, "late": 0},
        "results_of_server": {"127.0.0.1:50051": count},
        "results_of_client": [count // clients + (i < count % clients) for i in range(clients)],
        "least_share_percent": 100.0 * (count // clients) * clients / count if count else None,
        "errors": {"FAILED DEADLINE_EXCEEDED": lost} if lost else {}, "frames_per_s": rate, "mpoints_per_s": rate * 0.3072,
        "latency_ms": latency, "since_sent_ms": percentiles(since_sent, lost)[0], "latency_beyond": beyond, "too_few_samples_for": [],
        "latency_histogram": histogram(everything, lost), "since_sent_histogram": histogram(since_sent, lost), "timeline": timeline,
        "bytes_up": 4_608_100 * count, "bytes_down": 307_300 * count, "stages_ms": stages, "client_cpu_ms_per_frame": 3.2,
        "client_busy_cpus": 0.15, "verified": None, "mismatches": None, "objectives": [], "codecs": [codec], "points": [], "search": None,
        "server_metrics": None, "faults": None, "findings": []} | changes


def lognormal_seconds(seed, seconds=30, rate=60, median=30.0, sigma=0.25, scale=1.0):
    """Latencies whose logarithms are normal: for each second an array of `rate` milliseconds."""
    random = numpy.random.default_rng(seed)
    return [scale * median * numpy.exp(sigma * random.standard_normal(rate)) for _ in range(seconds)]


def eventful():
    """A load test in which everything happens that a report shows: a stall, failures, two codecs, a sweep, metrics, findings."""
    latencies = lognormal_seconds(7)
    latencies[12] = latencies[12] + numpy.linspace(2000, 20, len(latencies[12]))
    failed = [0] * 30
    failed[13] = 11
    told = load_test(latencies, failed, clients=8, codec="planar, rgbd",
                     errors={"FAILED DEADLINE_EXCEEDED": 7, "FAILED RESOURCE_EXHAUSTED QUEUE_FULL": 4},
                     results_of_client=[231, 229, 230, 228, 226, 232, 195, 229], least_share_percent=86.67)
    planar = told["codecs"][0]
    told["codecs"] = [planar | {"results": 910, "sent": 916, "failed": 6},
                      planar | {"codec": "rgbd", "results": 890, "sent": 895, "failed": 5, "bytes_up_per_frame": 132_000,
                                "client_cpu_ms_per_frame": None, "stages_ms": planar["stages_ms"] | {"client_encode": 8.0, "total": 38.3}}]
    told["points"] = [
        {"label": f"{clients} clients", "clients": clients, "offered_frames_per_s": None, "achieved_frames_per_s": achieved,
         "mpoints_per_s": achieved * 0.3072, "bytes_up_per_s": achieved * 4_608_100,
         "latency_ms": {"p50": p50, "p90": 1.2 * p50, "p95": 1.3 * p50, "p99": 1.5 * p50, "p99.9": None, "p99.99": None, "max": 2 * p50,
                        "mean": 1.05 * p50},
         "failed": clients // 8, "least_share_percent": 98.0, "server_cpu_ms_per_frame": 27.5, "verdict": verdict}
        for clients, achieved, p50, verdict in
        ((1, 31.4, 31.0, "met"), (2, 54.7, 36.0, "met"), (4, 65.3, 62.0, "met"), (8, 63.5, 126.0, "missed"), (16, 61.0, 260.0, "unstable"))]
    told["search"] = {"objective": "p99<100ms", "capacity_frames_per_s": 64.1, "low": 64.1, "high": 65.6,
                      "tries": [{"offered_frames_per_s": 64.1, "met": True}, {"offered_frames_per_s": 65.6, "met": False}]}
    told["objectives"] = [{"objective": "p99<100ms", "value": None, "met": False}, {"objective": "fps>=50", "value": 60.0, "met": True}]
    told["server_metrics"] = {
        "before": {"segserve_memory_bytes": 41e6}, "after": {"segserve_memory_bytes": 52e6}, "queue_wait_ms": {"p50": 1.8, "p99": 40.2},
        "rejected": {"QUEUE_FULL": 4}, "cpu_seconds": 51.2, "cpu_ms_per_frame": 28.4, "memory_bytes_max": 350_000_000}
    told["faults"] = {"vanish": 3, "cancel": 5}
    told["findings"] = [
        {"code": "UNSTABLE", "text": "The run was unstable: the median of its second half is 12 % above that of the first half."},
        {"code": "TOO_FEW_SAMPLES", "text": "1,811 frames are too few for p99.99."}]
    told["too_few_samples_for"] = ["p99.99"]
    return told
