# SPDX-License-Identifier: Apache-2.0
"""What newcomers get wrong is told in one line that says what to do."""
import json
import shutil
import signal
import subprocess
import time
import unittest

from harness import BAD_INPUT, FAILED, SEGCTL, SEGSERVE, SUCCESS, EndToEnd, Server, segctl
import pcd

SMALL = ("--width", "160", "--height", "120")


class CommandLine(EndToEnd):
    def refuse(self, said, *arguments):
        self.assertEqual(self.run_badly(BAD_INPUT, *arguments), f"segctl: {said}\n")

    def test_the_name_that_was_meant_is_told(self):
        self.refuse("there is no command 'segmnt' (did you mean segctl segment?) (see segctl --help)", "segmnt", "x.pcd")
        self.refuse("unknown option --treshold (did you mean --threshold?) (see segctl segment --help)",
                    "segment", "x.pcd", "--treshold", "0.2")
        self.refuse("unknown option --serve (did you mean --server?) (see segctl health --help)",
                    "health", "--serve=localhost")
        self.refuse("unknown option -local (did you mean --local?) (see segctl segment --help)", "segment", "x.pcd", "-local")
        self.refuse("unknown option --drop-unlabeld (did you mean --drop-unlabeled?) (see segctl cut --help)",
                    "cut", "x", "--regions", "3", "--drop-unlabeld")
        scene = self.synth(*SMALL)
        self.refuse(f"there is no command '{scene}' (did you mean segctl segment {scene}?) (see segctl --help)", scene)

    def test_the_old_name_of_a_flag_is_taken_and_not_shown(self):
        result, scene = self.path("result"), self.synth(*SMALL)
        self.run_well("segment", scene, "--local", "-q", "--result", result)
        written = []
        for flag in ("--drop-unlabeled", "--drop-unlabelled"):
            output = self.path(f"{flag}.pcd")
            self.run_well("cut", result, "--regions", "3", "--cloud", scene, "-q", "-o", output, flag)
            written.append(output.read_bytes())
        self.assertEqual(*written)
        self.assertNotIn(b"labelled", self.run_well("cut", "--help-all").stdout)

    def test_a_name_that_promises_another_format_is_refused_before_any_work(self):
        scene = self.path("no such scene.pcd")  # would be told, too, if it were read
        for said, *arguments in (
                ("--json x.png: the summary is written as JSON, so that the name must not end in .png", "segment", scene, "--json", "x.png"),
                ("--json x.json.gz: the summary is written as JSON", "segment", scene, "--json", "x.json.gz"),
                ("--result x.pcd: the result is written in a format of its own", "segment", scene, "--result", "x.pcd"),
                ("-o x.pdf: a page is written as HTML, so that the name must end in .html or .htm", "view", scene, "-o", "x.pdf"),
                ("--html x.md: a page is written as HTML", "eval", "--data", self.folder, "--html", "x.md"),
                ("--markdown x.html: the tables are written as Markdown", "eval", "--data", self.folder, "--markdown", "x.html"),
                ("--csv x.png: the timeline is written as CSV", "bench", "--csv", "x.png"),
                ("--html x.json: a page is written as HTML", "bench", "show", scene, "--html", "x.json")):
            self.assertIn(said, self.run_badly(BAD_INPUT, *arguments))

    def test_an_empty_value_is_told(self):
        self.refuse("--picture is empty; --json is empty", "segment", "x.pcd", "--picture", "", "--json", "")

    def test_a_flag_without_effect_is_told(self):
        scene, result = self.synth(*SMALL), self.path("result")
        self.run_well("segment", scene, "--local", "-q", "--result", result)
        for said, *arguments in (
                ("--color says how a cloud is written, and none is: -o FILE writes one", "segment", scene, "--color", "segment"),
                ("--encoding says how a cloud is written", "segment", scene, "--encoding", "binary", "--picture", "x.png"),
                ("--drop-unlabeled says how a cloud is written", "cut", result, "--regions", "2", "--drop-unlabeled"),
                ("--color says how a cloud is written", "synth", "--picture", "x.png", "--color", "own"),
                ("--tls-ca is for a server: not together with --local", "segment", scene, "--local", "--tls-ca", "x.pem"),
                ("--compare is for clouds that are segmented", "view", result, "--cloud", scene, "-o", "x.html", "--compare", "color"),
                ("--threshold is for clouds that are segmented", "view", result, "--cloud", scene, "-o", "x.html", "--threshold", "0.1"),
                ("--segments needs --json, --result or --out-dir", "segment", self.folder, "--contact-sheet", "x.png", "--segments"),
                ("--worst needs --markdown or --html", "eval", "--data", self.folder, "--worst", "3"),
                ("--cloud is for saved results", "view", scene, "--cloud", scene, "-o", "x.html")):
            self.assertIn(said, self.run_badly(BAD_INPUT, *arguments))

    def test_everything_wrong_is_told_at_once(self):
        self.refuse("unknown option --bogus-flag; --threshold: 'high' is no number; --regions: 'few' is no whole number; "
                    "--parallel needs --out-dir (see segctl segment --help)",
                    "segment", "x.pcd", "--threshold", "high", "--bogus-flag", "--regions", "few", "--parallel", "2")
        self.refuse("--objects: -1 is negative, but must be a whole number of at least 0; "
                    "--width: '1.5' is no whole number (see segctl synth --help)",
                    "synth", "-o", "x.pcd", "--objects", "-1", "--width", "1.5")

    def test_a_value_that_is_missing_is_asked_for(self):
        self.refuse("--json needs FILE after it (see segctl info --help)", "info", "--json")
        self.refuse("RESULT is required (see segctl cut --help)", "cut", "--regions", "3")

    def test_no_count_may_be_negative(self):
        for flags in (("synth", "-o", "x.pcd", "--seed"), ("synth", "-o", "x.pcd", "--objects"),
                      ("synth", "-o", "x.pcd", "--height"), ("synth", "-o", "x.pcd", "--fused", "--points"),
                      ("bench", "--seed"), ("bench", "--clients"), ("bench", "--scenes"), ("bench", "--in-flight"),
                      ("eval", "--data", ".", "--seed"), ("segment", ".", "--out-dir", "x", "--parallel")):
            with self.subTest(flags=flags):
                self.assertIn(f"{flags[-1]}: -1 ", self.run_badly(BAD_INPUT, *flags, "-1"))

    def test_no_output_takes_the_place_of_an_input(self):
        scene = self.synth(*SMALL)
        before = scene.read_bytes()
        link, folder, rig = self.path("link.pcd"), self.path("folder"), self.path("rig")
        link.symlink_to(scene)
        folder.mkdir()
        (folder / "a.pcd").hardlink_to(scene)
        twin = self.path("twin")  # whose name tells no format
        twin.hardlink_to(scene)
        result = self.path("scene.segres")
        self.run_well("segment", scene, "--local", "--result", result)
        self.run_well("synth", *SMALL, "--rig", rig)
        for flags in ((scene, "--picture", scene), (scene, "--dendrogram", link), (link, "--json", scene),
                      (scene, "--result", scene), (folder, "--contact-sheet", folder / "a.pcd"),
                      (folder, "--out-dir", self.path("out"), "--json", link),
                      ("--cameras", rig / "cameras.json", "--picture", rig / "cameras.json"),
                      ("--cameras", rig / "cameras.json", "-o", rig / "camera_0.pcd")):
            with self.subTest(flags=flags):
                self.assertIn("would be overwritten by an output", self.run_badly(BAD_INPUT, "segment", "--local", *flags))
        for command in (("cut", result, "--threshold", "0.5", "--json", result),
                        ("cut", result, "--threshold", "0.5", "--cloud", scene, "--picture", scene),
                        ("pick", result, "--cloud", scene, "--include", "80,60", "--json", scene),
                        ("info", scene, "--json", scene), ("stream", scene, "--json", link),
                        ("eval", "--data", folder, "--json", twin),
                        ("segment", folder, "--local", "--track", "--json", twin)):
            with self.subTest(command=command):
                self.assertIn("would be overwritten by an output", self.run_badly(BAD_INPUT, *command))
        self.assertEqual(scene.read_bytes(), before)
        self.run_well("segment", scene, "--local", "-o", scene)  # which holds the cloud and its labels
        self.assertIn(b"label", scene.read_bytes())

    def test_nan_is_no_number_of_a_range(self):
        scene = self.synth(*SMALL)
        for flags in (("stream", scene, "--rate", "nan"), ("stream", scene, "--speed", "nan"),
                      ("stream", scene, "--duration", "nan"), ("bench", "--rate", "nan"), ("bench", "--duration", "nan"),
                      ("segment", scene, "--local", "--track", "--rate", "nan", "--out-dir", self.path("tracked"))):
            with self.subTest(flags=flags):
                self.assertIn("nan", self.run_badly(BAD_INPUT, *flags))
        self.refuse("--html-live 127.0.0.1:99999: it must be HOST:PORT, with a port up to 65535",
                    "stream", scene, "--html-live", "127.0.0.1:99999")
        self.refuse("--view-from needs --picture or --plain-picture", "segment", scene, "--local", "--view-from", "1,1,1")
        self.refuse("--view-from 1e300,0,0: must be X,Y,Z, a position in meters such as 1.5,-2,1",
                    "segment", scene, "--local", "--picture", "p.png", "--view-from", "1e300,0,0")

    def test_the_server_tells_all_faults_too(self):
        done = subprocess.run([SEGSERVE, "--treads", "3", "--workers", "many", "--queue", "-1"], capture_output=True,
                              timeout=60)
        self.assertEqual((done.returncode, done.stdout), (BAD_INPUT, b""))
        self.assertEqual(done.stderr.decode(),
                         "segserve: unknown option --treads (did you mean --threads?); --workers: 'many' is no whole number; "
                         "--queue: -1 is negative, but must be a whole number of at least 0 (see segserve --help)\n")


class CutOfAnotherCloud(EndToEnd):
    """The number of points is the same for every frame of a camera: a saved result knows its cloud."""

    def setUp(self):
        self.scene, self.other = (self.synth("--seed", seed, *SMALL, name=f"{seed}.pcd") for seed in (1, 2))
        self.output = self.path("cut.pcd")

    def result(self, *arguments):
        path = self.path("saved.segres")
        self.run_well("segment", *arguments, "-q", "--result", path)
        return path

    def cut(self, result, cloud):
        return "cut", result, "--regions", "5", "--cloud", cloud, "-o", self.output, "-q"

    def test_is_refused_whatever_way_the_cloud_was_sent(self):
        for way in (("--local",), ("--server", self.server.address), ("--server", self.server.address, "--codec", "pcd"),
                    ("--server", self.server.address, "--codec", "quantised")):
            with self.subTest(way=way):
                result = self.result(self.scene, *way)
                self.run_well(*self.cut(result, self.scene))
                self.output.unlink()
                line = self.run_badly(BAD_INPUT, *self.cut(result, self.other))
                self.assertEqual(line, f"segctl: {self.other} is not the cloud that was segmented for {result}: it has as many "
                                       "points, but other ones\n")
                self.assertFalse(self.output.exists())
                self.run_badly(BAD_INPUT, "cut", result, "--regions", "5", "--cloud", self.other, "--segments", "--json", "-")

    def test_the_format_of_the_file_does_not_matter(self):
        result, ply = self.result(self.scene, "--local"), self.path("same.ply")
        self.run_well("segment", self.scene, "--local", "--json", "-", "-o", ply, "--encoding", "ascii")
        self.run_well(*self.cut(result, ply))
        self.run_well(*self.cut(result, "-"), stdin=ply.read_bytes())

    def test_images_have_a_cloud_too(self):
        depth, color, cloud = self.path("depth.png"), self.path("color.jpg"), self.path("cloud.pcd")
        said = self.run_well("synth", *SMALL, "--depth", depth, "--rgb", color).stdout.decode()
        flags = said.split("segctl segment ")[1].split()
        for way in (("--local",), ("--server", self.server.address)):
            result = self.result(*flags, *way, "-o", cloud)
            self.run_well(*self.cut(result, cloud))
            self.run_badly(BAD_INPUT, *self.cut(result, self.other))

    def test_other_colors_are_mentioned(self):
        result, painted = self.result(self.scene, "--local"), self.path("painted.pcd")
        self.run_well("segment", self.scene, "--local", "-q", "-o", painted, "--color", "segment")
        done = segctl(*self.cut(result, painted))
        self.assertEqual(done.returncode, SUCCESS)
        self.assertEqual(done.stderr.decode(),
                         f"segctl: {painted} has other colors than the cloud that was segmented\n")

    def test_an_older_result_is_read_with_a_warning(self):
        result = self.result(self.scene, "--local")
        line, content = result.read_bytes().split(b"\n", 1)
        words = line.split()
        self.assertEqual(len(words), 6)
        result.write_bytes(b" ".join([words[0], b"2", *words[2:4]]) + b"\n" + content)
        done = segctl(*self.cut(result, self.scene))
        self.assertEqual(done.returncode, SUCCESS)
        self.assertRegex(done.stderr.decode(), r"\Asegctl: [^\n]* does not tell which cloud it belongs to[^\n]*\n\Z")
        self.assertTrue(self.output.exists())


class NoServer(EndToEnd):
    def test_a_server_that_is_not_there_is_named_with_what_to_do(self):
        scene, nobody = self.synth(*SMALL), "127.0.0.1:1"
        said = f"segctl: no answer from {nobody}: Connection refused; is segserve running there?"
        for command in (("health",), ("info",), ("bench", "--duration", "0.1", "--warm-up", "0")):
            self.assertEqual(self.run_badly(FAILED, *command, "--server", nobody), said + "\n")
        for command in (("segment", scene), ("segment", scene, "--out-dir", self.path("out"))):
            self.assertEqual(self.run_badly(FAILED, *command, "--server", nobody), said + " --local works without\n")

    def test_an_address_that_cannot_be_is_refused(self):
        for address, said in (("127.0.0.1:99999", "the port of '127.0.0.1:99999' is no number from 1 to 65535"),
                              ("127.0.0.1:0", "the port of '127.0.0.1:0' is no number from 1 to 65535"),
                              ("robot:http", "the port of 'robot:http' is no number from 1 to 65535"),
                              ("https://robot:50051", "is a URL; the address of a server is HOST:PORT")):
            with self.subTest(address=address):
                self.assertIn(said, self.run_badly(BAD_INPUT, "health", "--server", address))


class StoppedBatch(EndToEnd):
    """What was done stays whole, the rest is not there, and the same command goes on."""

    FILES = 24

    def setUp(self):
        self.inputs, self.outputs = self.path("in"), self.path("out")
        self.inputs.mkdir()
        scene = self.synth(*SMALL)
        for i in range(self.FILES):
            shutil.copy(scene, self.inputs / f"{i:02}.pcd")

    def start(self, *where):
        return subprocess.Popen([SEGCTL, "segment", self.inputs, "--out-dir", self.outputs, "--parallel", "1", *where],
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def wait_for_an_output(self, process):
        while not list(self.outputs.glob("*.json")):
            self.assertIsNone(process.poll(), "the batch ended early")
            time.sleep(0.002)

    def check(self, process, exit_code, reason):
        stdout, stderr = process.communicate(timeout=60)
        self.assertEqual(process.returncode, exit_code, stderr)
        done = len(list(self.outputs.glob("*.json")))
        self.assertLess(done, self.FILES)
        self.assertRegex(stderr.decode(), rf"\Asegctl: {reason}{done} of {self.FILES} done; run again to go on\n\Z")
        self.assertEqual(stdout.decode(), f"{done} segmented, 0 done before, 0 failed, {self.FILES - done} not done\n")
        names = {path.name for path in self.outputs.iterdir()}
        self.assertEqual(names, {f"{path.stem}{kind}" for path in self.outputs.glob("*.json") for kind in (".pcd", ".json")})
        again = self.run_well("segment", self.inputs, "--out-dir", self.outputs, "--local").stdout.decode()
        self.assertEqual(again, f"{self.FILES - done} segmented, {done} done before, 0 failed\n")

    def test_ctrl_c_stops_a_batch_between_two_files(self):
        for number, name in ((signal.SIGINT, "int"), (signal.SIGTERM, "term")):
            for where in (("--local",), ("--server", self.server.address)):
                with self.subTest(signal=name, where=where):
                    process = self.start(*where)
                    self.wait_for_an_output(process)
                    process.send_signal(number)
                    self.check(process, 130, "")
                    shutil.rmtree(self.outputs)

    def test_a_server_that_is_gone_stops_a_batch(self):
        server = Server(self.folder)
        self.addCleanup(server.close)
        process = self.start("--server", server.address, "--timeout", "4")
        self.wait_for_an_output(process)
        server.close()
        began = time.monotonic()
        self.check(process, FAILED, rf"no server has been in reach for 2 s \(no answer from {server.address}: [^\n]*\): ")
        self.assertLess(time.monotonic() - began, 30)

    def test_what_was_not_done_is_told_in_json(self):
        process = self.start("--local", "--json", "-")
        self.wait_for_an_output(process)
        process.send_signal(signal.SIGINT)
        lines = [json.loads(line) for line in process.communicate(timeout=60)[0].splitlines()]
        self.assertEqual(len(lines), self.FILES)
        unfinished = [line for line in lines if line["state"] != "segmented"]
        self.assertGreater(len(unfinished), 0)
        for line in unfinished:
            self.assertEqual([line[key] for key in ("state", "output", "points", "segments", "error")],
                             ["unfinished", None, None, None, None])


class FilesOfOneName(EndToEnd):
    def names(self, folder):
        return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}

    def segment(self, *arguments):
        return self.run_well("segment", *arguments, "--local").stdout.decode()

    def test_are_told_apart_by_extension_and_folder(self):
        a, b, out = self.path("a"), self.path("b"), self.path("out")
        for path in (a / "s1.pcd", a / "s1.ply", a / "s2.ply", b / "s1.pcd", b / "s3.pcd"):
            path.parent.mkdir(exist_ok=True)
            self.run_well("synth", "--json", "-", "-o", path, *SMALL)
        self.assertEqual(self.segment(a, "--out-dir", out), "3 segmented, 0 done before, 0 failed\n")
        self.assertEqual(self.names(out), {f"{name}{kind}" for name in ("s1", "s1.ply", "s2") for kind in (".pcd", ".json")})
        self.assertEqual(json.loads((out / "s1.ply.json").read_text())["batch"]["input"], str(a / "s1.ply"))
        self.assertEqual(self.segment(a, "--out-dir", out), "0 segmented, 3 done before, 0 failed\n")
        self.assertEqual(self.segment(a / "s1.pcd", a / "s1.ply", a / ".." / a.name / "s1.ply", "--out-dir", out),
                         "0 segmented, 2 done before, 0 failed\n", "a file that is given twice is one file")
        out = self.path("both")
        self.assertEqual(self.segment(a, b, "--out-dir", out), "5 segmented, 0 done before, 0 failed\n")
        self.assertEqual(self.names(out), {f"{name}{kind}" for kind in (".pcd", ".json")
                                           for name in (f"{a.name}/s1", "s1.ply", "s2", f"{b.name}/s1", "s3")})
        self.assertEqual(self.segment(b, a, "--out-dir", out), "0 segmented, 5 done before, 0 failed\n")

    def test_an_output_of_another_file_is_not_taken_for_done(self):
        a, out = self.path("a"), self.path("out")
        a.mkdir()
        self.run_well("synth", "--json", "-", "-o", a / "s1.ply", *SMALL)
        self.segment(a, "--out-dir", out)
        (a / "s1.ply").rename(a / "s1.pcd")  # the name of a file does not matter to its reader
        self.assertEqual(self.segment(a, "--out-dir", out), "1 segmented, 0 done before, 0 failed\n")
        (out / "s1.json").write_text('{"batch": {"key": 3, "input": [], "input_bytes": "x"}, "points": "many"}')
        self.assertEqual(self.segment(a, "--out-dir", out), "1 segmented, 0 done before, 0 failed\n")

    def test_a_folder_without_out_dir_is_told_of_it(self):
        line = self.run_badly(BAD_INPUT, "segment", self.folder, "--local")
        self.assertEqual(line, f"segctl: {self.folder} is a folder: --out-dir DIR segments all files in it and writes their "
                               "labels to DIR\n")


class EvalWithABadFile(EndToEnd):
    def test_scores_the_rest_and_tells_at_the_end(self):
        data = self.path("data")
        data.mkdir()
        for seed in (1, 2):
            self.run_well("synth", "-q", "--seed", seed, "-o", data / f"{seed}.pcd", *SMALL)
        (data / "1b.pcd").write_bytes(b"no cloud")
        (data / "3.pcd").write_bytes(pcd.ascii_file([(0, 0, 1), (0, 1, 1)]))
        done = segctl("eval", "--data", data, "--json", "-")
        self.assertEqual(done.returncode, BAD_INPUT)
        told = json.loads(done.stdout)
        self.assertEqual([row["file"] for row in told["per_scene"]], ["1.pcd", "2.pcd"])
        self.assertEqual([row["file"] for row in told["failed"]], ["1b.pcd", "3.pcd"])
        lines = done.stderr.decode().splitlines()
        self.assertEqual(len(lines), 3)
        self.assertEqual([line.split(": ", 1)[1] for line in lines[:2]], [row["error"] for row in told["failed"]])
        self.assertEqual(lines[2], "segctl: 2 of 4 scenes failed")
        alone = self.path("alone")
        alone.mkdir()
        for seed in (1, 2):
            shutil.copy(data / f"{seed}.pcd", alone)
        good = json.loads(self.run_well("eval", "--data", alone, "--json", "-").stdout)
        self.assertEqual(good["one_to_one"], told["one_to_one"])
        self.assertEqual(good["failed"], [])

    def test_without_any_score_there_is_no_table(self):
        data = self.path("data")
        data.mkdir()
        for name in ("1.pcd", "2.ply"):
            (data / name).write_bytes(b"no cloud")
        done = segctl("eval", "--data", data)
        self.assertEqual((done.returncode, done.stdout), (BAD_INPUT, b""))
        self.assertEqual(done.stderr.decode().splitlines()[-1], "segctl: 2 of 2 scenes failed")


if __name__ == "__main__":
    unittest.main()
