"""Reports of results and studies: what their texts, tables and plots say, without a browser."""

import re
from dataclasses import replace

import found_studies
import numpy as np
import pytest
from conftest import DATA
from report_pages import data_of, own_text
from shipped_cells import still_motion
from shown_results import AWKWARD, UGLY_JOINTS, with_awkward_names

import mrts
from mrts.cli import main
from mrts.output.report_page import report_html
from mrts.output.report_player import player
from mrts.plots.phase_plane import phase_plane_plot
from mrts.plots.plot import Line
from mrts.scene.scene import Scene


def test_names_of_a_study_stay_text_and_its_page_loads_nothing():
    kinds = found_studies.kinds()
    text, plain = (own_text(report_html(kinds[name])) for name in ("many numbers", "grid"))
    assert not re.search(r"https?://|//[a-z]|\b(src|href)=.(?!#)|@import|url\(", plain)
    assert found_studies.AWKWARD not in text
    assert "&lt;img src=x onerror=window.broken=1&gt;" in text


def test_a_folder_of_a_study_is_reported(tmp_path, capsys):
    study = tmp_path / "study.yaml"
    files = f"cell: {DATA / 'cell.yaml'}\nmotion: {DATA / 'lift.yaml'}"
    study.write_text(f"{files}\nvary:\n  object.mass: [0.5, 3, 300]\n", encoding="utf-8")
    found = mrts.sweep(study, tmp_path / "found", workers=1).to_pandas()
    target = tmp_path / "report.html"
    assert main(["report", str(tmp_path / "found"), "-o", str(target)]) == 0
    assert "planar_dual_arm: 2 of 3 variants may be played (66.6 %); 1 infeasible" in capsys.readouterr().out
    text = target.read_text(encoding="utf-8")
    assert f"{found.duration.min():.4g} s" in text
    assert "object.mass: 0.5, 3, 300 kg" in text
    for part in (tmp_path / "found").glob("rows/*.parquet"):
        part.unlink()
    assert main(["report", str(tmp_path / "found")]) == 2
    assert "no variant of this study is solved yet" in capsys.readouterr().err


DRAWN = 1e-5
"""Numbers of a page have six digits."""


@pytest.mark.quick
def test_names_stay_text_and_the_page_loads_nothing(planar_cell, lift, lifted):
    text = own_text(report_html(lifted))
    assert not re.search(r"https?://|//[a-z]|\b(src|href)=.(?!#)|@import|url\(", text)
    assert "default-src 'none'" in text
    text = own_text(report_html(mrts.scale(with_awkward_names(planar_cell), lift)))
    assert text.count("</script>") == 3  # of the library, the data and our own script
    assert not [name for name in (AWKWARD, *UGLY_JOINTS) if name in text]
    assert "&lt;/script&gt;&lt;script&gt;window.broken=1&lt;/script&gt;" in text
    names = [trace["name"] for trace in data_of(text)["plots"]["plot-torques_and_wrenches-0"]["data"] if trace["name"]]
    assert all("<" not in name and "$" not in name for name in names)


def test_arrows_of_the_player_are_the_forces_at_the_contacts(turned):
    shown = player(turned)
    ((_, coordinates),) = [
        pair for pair in zip(shown["data"], shown["frames"], strict=False) if pair[0]["name"] == "force on the object"
    ]
    line = np.stack([np.array(coordinates[axis], dtype=float) for axis in "xyz"], axis=-1)
    arrows = line.reshape(turned.motion.samples, 2, 3, 3)
    point, force, _ = Scene.of(turned.trajectory).contacts
    shaft = arrows[:, :, 1] - arrows[:, :, 0]
    scale = np.max(np.linalg.norm(shaft, axis=-1)) / shown["largest_force"]
    np.testing.assert_allclose(arrows[:, :, 0], point, atol=2 * DRAWN)
    np.testing.assert_allclose(shaft, scale * force, atol=4 * DRAWN)


@pytest.mark.quick
def test_the_text_says_what_was_given_and_found(planar_cell, lift, lifted):
    text = report_html(lifted)
    for words in (
        "c² ∈ [0, 3.062]: you may play it up to 1.75 × as fast",
        "At c² = 3.06181 the motors give ",
        "left (3 joints), right (3 joints); xy; load 0.5 kg",
        "<td>0.5236 s in 101 samples</td>",
        "<td>1.25, 1.5, 0 m</td>",
        "[-80, 80] N m",
        "<td>left/elbow torque</td><td>100 %, binds</td>",
    ):
        assert words in text, words
    infeasible = report_html(mrts.scale(planar_cell.with_mass(24.0), lift))
    assert "50 samples from 0 s to 0.2566 s" in infeasible
    assert "these limits conflict" in infeasible
    uncertain = report_html(mrts.scale(planar_cell.with_variation(mass=(0.2, 6.0)), lift))
    assert "<td>mass 3 kg</td>" in uncertain
    still = mrts.scale(planar_cell, still_motion(lift.position[0]))
    assert still.status.advice in report_html(still)


@pytest.mark.quick
def test_a_saved_result_is_reported(lifted, tmp_path, capsys):
    mrts.save_result(lifted, tmp_path / "result.npz")
    target = tmp_path / "report.html"
    assert main(["report", str(tmp_path / "result.npz"), "-o", str(target)]) == 0
    assert "planar_dual_arm: feasible" in capsys.readouterr().out
    assert target.read_text(encoding="utf-8") == report_html(mrts.load_result(tmp_path / "result.npz"))
    assert report_html(mrts.load_result(tmp_path / "result.npz", cell=lifted.cell)) == report_html(lifted)
    with pytest.raises(mrts.InputError, match="cannot be written"):
        mrts.write_report(lifted, tmp_path / "result.npz" / "report.html")
    (tmp_path / "no.npz").write_text("nothing")
    assert main(["report", str(tmp_path / "no.npz")]) == 2
    assert "no.npz" in capsys.readouterr().err


def sections(text):
    """Names of the sections in their order."""
    return re.findall(r'<section id="([^"]+)"', text)


@pytest.mark.quick
def test_the_timing_stands_first_with_saving_limits_and_phase_plane(planar_cell, lift):
    timing = mrts.retime(planar_cell, lift)
    text = report_html(timing)
    assert sections(text)[:2] == ["timing", "motion"]
    sentence = timing.sentence()
    assert f"{sentence[0].upper()}{sentence[1:]}" in text
    name, share = timing.limits[0]
    assert f"limited by {name}, {100 * share:.0f} % of the time" in text
    for name, share in timing.limits:
        assert f"<td>{name}</td><td>{100 * share:.3g} %</td>" in text
    curves = [item for item in phase_plane_plot(timing).rows[0][0].items if isinstance(item, Line)]
    traces = {trace.get("name"): trace for trace in data_of(text)["plots"]["plot-phase_plane"]["data"]}
    assert [curve.label.split(",")[0] for curve in curves[-2:]] == ["fastest", "best constant c"]
    for curve in curves:
        np.testing.assert_allclose(traces[curve.label]["x"], curve.x, rtol=DRAWN)
        np.testing.assert_allclose(traces[curve.label]["y"], curve.y, rtol=DRAWN)
    links = re.findall(r'<a href="#([^"]+)"', text)
    assert links == sections(text)


@pytest.mark.quick
def test_limits_that_set_the_speed_stand_first(lifted, planar_cell, lift):
    end = lifted.range.upper
    assert lifted.setting_rows() == [row.name for row in end.rows]
    assert mrts.scale(planar_cell, lift, 0.5 * end.c2).setting_rows() == []
    marked = [row[1].endswith(", binds") for row in lifted.limits_table().rows]
    assert marked == [True] * len(end.rows) + [False] * (len(lifted.uses) - len(end.rows))


@pytest.mark.quick
def test_changes_are_a_table_of_what_each_does_and_what_limits_then(lifted):
    found = lifted.what_if()
    text = report_html(replace(lifted, changes=found))
    first = found.changes[0]
    assert f"<td>{first.change}</td><td>{first.effect}</td>" in text
    assert ("what-if" in sections(text), "what-if" in sections(report_html(lifted))) == (True, False)


def test_stops_are_told_and_drawn_where_they_are_asked_for(planar_cell, lift, tmp_path, capsys):
    plan = mrts.retime(planar_cell, lift, rates=20, reserve=0.5)
    mrts.save_result(plan, tmp_path / "result.npz")
    asked = ["report", str(tmp_path / "result.npz"), "-o", str(tmp_path / "report.html")]
    cell = ["--cell", str(DATA / "cell.yaml")]
    longest = []
    for rates in (None, 80):
        stops = mrts.SpeedOverride(plan, rates=rates).stops()
        assert main([*asked, *cell, *([] if rates is None else ["--rates", str(rates)])]) == 0
        text = (tmp_path / "report.html").read_text(encoding="utf-8")
        assert stops.sentence()[1:] in text
        time, distance = (np.array(trace["y"], dtype=float) for trace in data_of(text)["plots"]["plot-stops"]["data"])
        np.testing.assert_allclose(time, 1e3 * stops.stop_time, rtol=DRAWN)
        np.testing.assert_allclose(distance, 1e3 * stops.distance, rtol=DRAWN)
        longest.append(np.max(time))
    assert longest[1] > longest[0]
    assert "stops" not in sections(report_html(plan))
    assert main([*asked, "--rates", "80"]) == 2
    assert main(["report", str(tmp_path), *cell]) == 2
    told = capsys.readouterr().err
    assert [key in told for key in ("--rates", "--cell")] == [True, True]
