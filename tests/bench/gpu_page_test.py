#!/usr/bin/env python3
"""bench/gpu as a machine with a GPU would run it: gpu_page_test.py BIN"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

GPU = pathlib.Path(__file__).resolve().parent.parent.parent / "bench" / "gpu"
sys.path.insert(0, str(GPU))
import icd  # noqa: E402
import model  # noqa: E402

BIN = pathlib.Path(sys.argv.pop(1))


def rows(pairs):
    base = "stages/camera/"
    out = {base + "visible": 90_000.0, base + "instances": float(pairs), base + "rays_in_tiles": 230_400.0}
    for stage in model.REACHED:
        out[f"{base}{stage}/traffic"] = 30.0
    out[base + "project/arithmetic"] = out[base + "project_backward/arithmetic"] = 90.0
    return out


def page(folder, *words, bin_folder=BIN):
    return subprocess.run([sys.executable, GPU / "run.py", bin_folder, "-o", folder, *words], capture_output=True, text=True, check=False)


class Model(unittest.TestCase):
    def test_faster_cards_and_fewer_pairs_take_less_time(self):
        base = "stages/camera"
        frame = {card: model.predict(rows(150_000), base, model.CARDS[card])["frame"] for card in model.CARDS}
        self.assertLess(frame["H100"], frame["RX 7900 XTX"])
        self.assertLess(frame["RX 7900 XTX"], frame["Arc A770"])
        self.assertLess(model.predict(rows(100_000), base, model.CARDS["H100"])["frame"], frame["H100"])

    def test_a_frame_is_the_sum_of_its_stages_and_no_less_than_its_launches(self):
        predicted = model.predict(rows(150_000), "stages/camera", model.CARDS["H100"])
        self.assertAlmostEqual(predicted["frame"], sum(predicted[s] for s in ("rays", "project", "bin", "sort", "blend")))
        self.assertLess(predicted["of it launches and waits"], predicted["frame"])

    def test_rows_without_counts_are_refused(self):
        with self.assertRaises(SystemExit):
            model.bases({"stages/camera/frame": 1.0})


class Icd(unittest.TestCase):
    def test_a_driver_that_no_file_names_is_added_to_those_that_are(self):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            maps = pathlib.Path("/proc/self/maps").read_text().splitlines()
            libc = next(line.split()[-1] for line in maps if ".so" in line and "/libc" in line)
            (folder / "driver").mkdir()
            shutil.copy(libc, folder / "driver" / "libigdrcl.so")
            (folder / "vendors").mkdir()
            (folder / "vendors" / "pocl.icd").write_text("libpocl.so.2\n")
            before, os.environ["OCL_ICD_VENDORS"] = os.environ.get("OCL_ICD_VENDORS"), str(folder / "vendors")
            folders, icd.FOLDERS = icd.FOLDERS, (str(folder / "driver"),)
            try:
                made = icd.vendors_folder(folder / "made")
                self.assertEqual(sorted(f.name for f in made.iterdir()), ["libigdrcl.icd", "pocl.icd"])
                self.assertEqual((made / "libigdrcl.icd").read_text().strip(), str(folder / "driver" / "libigdrcl.so"))
                (folder / "vendors" / "intel.icd").write_text("/opt/intel/libigdrcl.so\n")
                self.assertIsNone(icd.vendors_folder(folder / "again"))
            finally:
                icd.FOLDERS = folders
                if before is None:
                    del os.environ["OCL_ICD_VENDORS"]
                else:
                    os.environ["OCL_ICD_VENDORS"] = before


class Page(unittest.TestCase):
    def test_tells_the_device_and_that_nothing_failed(self):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary) / "page"
            done = page(folder, "--parts", "check")
            self.assertEqual(done.returncode, 0, done.stderr)
            data = json.loads((folder / "page.json").read_text())
            self.assertEqual(data["failures"], [])
            text = (folder / "page.md").read_text()
            self.assertIn(data["device"]["name"], text)
            self.assertIn("largest error", text)
            self.assertTrue(text.rstrip().endswith("- none"))

    def test_a_part_that_fails_is_told_and_the_page_is_there(self):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            programs = folder / "bin"
            programs.mkdir()
            (programs / "simuli").write_text(f'#!/bin/sh\n[ "$1" = bench ] && {{ echo "simuli: no bench" >&2; exit 9; }}\n'
                                             f'exec "{BIN.resolve()}/simuli" "$@"\n')
            (programs / "simuli").chmod(0o755)
            done = page(folder / "page", "--parts", "stages", bin_folder=programs)
            self.assertEqual(done.returncode, 1, done.stderr)
            failures = json.loads((folder / "page" / "page.json").read_text())["failures"]
            self.assertEqual(len(failures), 1)
            self.assertIn("simuli: no bench", failures[0])
            self.assertIn("no bench", (folder / "page" / "page.md").read_text())

    def test_devices_and_folders_that_are_not_there_are_refused_in_a_line(self):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            for words, bin_folder in ((("--device", "no such device"), BIN), ((), folder)):
                done = page(folder / "page", *words, bin_folder=bin_folder)
                self.assertEqual(done.returncode, 1)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                self.assertIn("run.py: ", done.stderr)


if __name__ == "__main__":
    unittest.main()
