"""Clicks through the pages of runs and studies in headless Chromium.

Needs `chromium` and `chromedriver` (Debian: chromium, chromium-driver) and the program, which PERIFRAC names.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import WebDriverWait

TITLE = 'A strip <b>"of" sand</b> & \'more\''

# The exact pressure falls evenly from left to right once it is steady; before, it is curved.
SCENE = f"""
title = {TITLE!r}
geometry = {{ type = "lattice", size = ["1 m", "0.5 m"], points = [20, 10] }}
fluid.viscosity = "1 mPa s"
materials.sand = {{ permeability = "1e-12 m^2", storage = "1e-9 1/Pa" }}
flow = {{ initial_pressure = 0, boundary.left.pressure = "1 MPa", boundary.right.pressure = 0 }}
output.times = ["0.1 s", "1 s"]
output.probes.near.at = ["0.25 m", "0.25 m"]
output.probes.far.at = ["0.75 m", "0.25 m"]
time.end = "50 s"
"""


def found(name):
    path = shutil.which(name)
    assert path, f"{name} is not installed: apt-get install chromium chromium-driver"
    return path


def browser(scripts=True, width=1100):
    options = webdriver.ChromeOptions()
    options.binary_location = found("chromium")
    for argument in ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]:
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    if not scripts:
        options.add_experimental_option("prefs", {"profile.managed_default_content_settings.javascript": 2})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(found("chromedriver")))
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    return driver


@pytest.fixture(scope="session")
def page(tmp_path_factory):
    """The page of a run with three outputs and a title that is full of what HTML takes as its own."""
    folder = tmp_path_factory.mktemp("pages")
    scene = folder / "scene.toml"
    scene.write_text(SCENE.replace(repr(TITLE), '"""' + TITLE + '"""'))
    program = os.environ["PERIFRAC"]
    subprocess.run([program, "run", str(scene), "--out", str(folder / "run"), "--quiet"], check=True)
    subprocess.run([program, "report", str(folder / "run"), "--frames", "velocity_x"], check=True)
    return folder / "run" / "report.html"


@pytest.fixture(scope="session")
def study(tmp_path_factory):
    """The page of a study, in which every method has a series of its own."""
    folder = tmp_path_factory.mktemp("study")
    program = os.environ["PERIFRAC"]
    command = [program, "study", "convergence", "two-layer", "--quick", "--budget", "15s", "--out", str(folder / "s")]
    subprocess.run(command, check=True)
    return folder / "s" / "report.html"


@pytest.fixture
def opened(page):
    driver = browser()
    driver.get(page.as_uri())
    yield driver
    errors = [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"]
    driver.quit()
    assert errors == []


def chart(driver, words):
    charts = driver.find_elements(By.CSS_SELECTOR, ".live.chart")
    return next(own for own in charts if words in own.find_element(By.CLASS_NAME, "name").text)


def range_of(driver, root, axis):
    return driver.execute_script(
        "const s = arguments[0].chart.chart.scales[arguments[1]]; return [s.min, s.max, s.type]", root, axis
    )


def pixels(driver, root, colour):
    """Pixels of a chart that have just this colour."""
    return driver.execute_script(
        """const canvas = arguments[0].querySelector('canvas');
        const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        let count = 0;
        for (let k = 0; k < data.length; k += 4)
          if (arguments[1].every((own, c) => data[k + c] === own)) count++;
        return count""",
        root,
        colour,
    )


def into_view(driver, node):
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", node)


BLUE = [0x00, 0x72, 0xB2]
ORANGE = [0xD5, 0x5E, 0x00]


def test_a_curve_is_hidden_and_shown_by_its_name(opened):
    root = chart(opened, "pressure over time")
    near, far = root.find_elements(By.CSS_SELECTOR, "button[data-group]")
    assert (near.text, far.text) == ("near", "far")
    blue, orange = pixels(opened, root, BLUE), pixels(opened, root, ORANGE)
    assert blue > 100 and orange > 100
    into_view(opened, near)
    near.click()
    assert near.get_attribute("aria-pressed") == "false"
    assert pixels(opened, root, BLUE) == 0 and pixels(opened, root, ORANGE) > 100
    near.send_keys(Keys.ENTER)
    assert near.get_attribute("aria-pressed") == "true"
    assert pixels(opened, root, BLUE) > 100


def test_what_is_framed_fills_the_chart_until_all_is_asked_for(opened):
    root = chart(opened, "pressure over time")
    canvas = root.find_element(By.TAG_NAME, "canvas")
    into_view(opened, canvas)
    low, high, _ = range_of(opened, root, "x")
    # Offsets are from the middle of the canvas.
    ActionChains(opened).move_to_element_with_offset(canvas, -100, -60).click_and_hold().move_by_offset(
        150, 120
    ).release().perform()
    near, far, _ = range_of(opened, root, "x")
    assert low < near < far < high and far - near < 0.4 * (high - low)
    root.find_element(By.CSS_SELECTOR, "button[aria-label='show all']").click()
    assert range_of(opened, root, "x")[:2] == [low, high]
    canvas.send_keys("+")
    assert range_of(opened, root, "x")[1] < high
    canvas.send_keys("0")
    assert range_of(opened, root, "x")[:2] == [low, high]


def test_axes_are_logarithmic_by_a_switch_that_tells_what_it_hides(opened):
    root = chart(opened, "pressure over time")
    switch = root.find_element(By.CSS_SELECTOR, "button[data-log='y']")
    into_view(opened, switch)
    assert range_of(opened, root, "y")[2] == "linear"
    switch.click()
    assert range_of(opened, root, "y")[2] == "logarithmic"
    assert "≤ 0 have no place" in root.find_element(By.CLASS_NAME, "readout").text
    switch.click()
    assert range_of(opened, root, "y")[2] == "linear"
    # The step is drawn over logarithmic axes from the start.
    assert range_of(opened, chart(opened, "time step"), "x")[2] == "logarithmic"


def test_values_are_read_off_with_pointer_and_keys(opened, page):
    root = chart(opened, "pressure over time")
    canvas, readout = root.find_element(By.TAG_NAME, "canvas"), root.find_element(By.CLASS_NAME, "readout")
    into_view(opened, canvas)
    ActionChains(opened).move_to_element(canvas).perform()
    WebDriverWait(opened, 5).until(lambda _: "time" in readout.text)
    canvas.send_keys(Keys.ARROW_UP)
    canvas.send_keys(*[Keys.ARROW_DOWN] * 2)
    first = readout.text
    assert re.fullmatch(r"(near|far): time 0 s, pressure 0 kPa", first), first
    canvas.send_keys(Keys.ARROW_RIGHT)
    rows = (page.parent / "history.csv").read_text().splitlines()
    head, second = rows[0].split(","), rows[2].split(",")
    time = float(second[head.index("time_s")])
    name = first.split(":")[0]
    pressure = float(second[head.index(f"pressure_{name}_Pa")])
    told = [float(own.replace("−", "-")) for own in re.findall(r"[−\d.]+(?:e[−\d]+)?", readout.text)]
    assert told == pytest.approx([time, pressure / 1e3], rel=1e-4)


def test_the_slider_shows_one_output_of_every_field(opened):
    slider = opened.find_element(By.CSS_SELECTOR, ".slider input")
    label = opened.find_element(By.CSS_SELECTOR, ".slider output")
    into_view(opened, slider)

    def shown(name):
        figures = opened.find_elements(By.CSS_SELECTOR, f".field[data-name='{name}'] figure")
        return [own.get_attribute("data-output") for own in figures if own.is_displayed()]

    assert shown("pressure") == shown("velocity_x") == ["0003"]
    assert label.text == "output 4 of 4, t = 50 s"
    slider.send_keys(Keys.ARROW_LEFT)
    assert shown("pressure") == shown("velocity_x") == ["0002"]
    assert label.text == "output 3 of 4, t = 1 s"


def test_a_field_tells_the_value_under_the_pointer(opened):
    view = opened.find_element(By.CSS_SELECTOR, ".field[data-name='pressure'] figure:not([hidden]) .view")
    readout = opened.find_element(By.CSS_SELECTOR, ".field[data-name='pressure'] .readout")
    other = opened.find_element(By.CSS_SELECTOR, ".field[data-name='velocity_x'] .readout")
    into_view(opened, view)

    def told():
        WebDriverWait(opened, 5).until(lambda _: "at the point" in readout.text)
        pattern = r"(\S+) Pa at the point x = (\S+) m, y = (\S+) m"
        return [float(own) for own in re.fullmatch(pattern, readout.text).groups()]

    ActionChains(opened).move_to_element(view).perform()
    pressure, x, y = told()
    # The flow is steady by then: the pressure falls evenly, and the flux is k/mu · 1 MPa/m.
    assert pressure == pytest.approx(1e6 * (1 - x), rel=1e-3)
    assert 0.3 < x < 0.7 and 0 < y < 0.5
    WebDriverWait(opened, 5).until(lambda _: other.text)
    assert float(other.text.split()[0]) == pytest.approx(1e-12 / 1e-3 * 1e6, rel=1e-3)
    view.send_keys(*[Keys.ARROW_RIGHT] * 5)
    WebDriverWait(opened, 5).until(lambda _: told()[1] > x)
    pressure, farther, _ = told()
    assert pressure == pytest.approx(1e6 * (1 - farther), rel=1e-3)
    view.send_keys("+")
    width = "return arguments[0].querySelector('img').getBoundingClientRect().width"
    assert opened.execute_script(width, view) == pytest.approx(2 * view.rect["width"], rel=0.01)
    view.send_keys("0")
    assert opened.execute_script(width, view) == pytest.approx(view.rect["width"], rel=0.01)


def test_titles_are_shown_as_they_are_written(opened):
    assert opened.find_element(By.TAG_NAME, "h1").text.endswith(TITLE)
    assert chart(opened, "pressure over time").find_element(By.CLASS_NAME, "name").text.startswith(TITLE)
    assert opened.find_elements(By.TAG_NAME, "b") == []


def test_nothing_is_fetched(opened):
    fetched = opened.execute_script("return performance.getEntriesByType('resource').map(own => own.name)")
    assert [own for own in fetched if not own.startswith("data:")] == []


def test_a_phone_has_no_sideways_scroll(page):
    driver = browser(width=390)
    driver.get(page.as_uri())
    assert driver.execute_script("return document.documentElement.scrollWidth") <= 390
    root = chart(driver, "pressure over time")
    assert root.find_element(By.TAG_NAME, "canvas").rect["width"] > 250
    assert pixels(driver, root, BLUE) > 100
    driver.quit()


def test_print_has_the_drawings(opened):
    opened.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert not any(own.is_displayed() for own in opened.find_elements(By.CSS_SELECTOR, "canvas, .slider, .tools"))
    figure = opened.execute_script("return document.querySelector('figure svg').closest('figure')")
    assert figure.find_element(By.TAG_NAME, "svg").is_displayed()
    pictures = opened.find_elements(By.CSS_SELECTOR, ".field[data-name='pressure'] img")
    assert [own.is_displayed() for own in pictures] == [True] * 4


def test_the_page_reads_without_scripts(page):
    driver = browser(scripts=False)
    driver.get(page.as_uri())
    assert driver.find_elements(By.TAG_NAME, "canvas") == []
    drawings = driver.find_elements(By.CSS_SELECTOR, "figure svg")
    pictures = driver.find_elements(By.CSS_SELECTOR, "figure img")
    assert len(drawings) >= 2 and len(pictures) >= 9
    assert all(own.is_displayed() for own in drawings + pictures)
    driver.quit()


def test_a_method_of_a_study_is_hidden_with_all_that_belongs_to_it(study):
    driver = browser()
    driver.get(study.as_uri())
    root = driver.find_element(By.CSS_SELECTOR, ".live.chart")
    method = root.find_element(By.CSS_SELECTOR, "button[data-group]")
    group = int(method.get_attribute("data-group"))
    into_view(driver, method)

    def visible():
        return driver.execute_script(
            """const c = arguments[0].chart.chart;
            return c.data.datasets.map((own, k) => [own.group, c.isDatasetVisible(k)])""",
            root,
        )

    before = visible()
    assert len([own for own in before if own[0] == group]) >= 2, "marks and the line through them"
    assert all(shown for _, shown in before)
    method.click()
    assert all(shown == (own != group) for own, shown in visible())
    driver.quit()
