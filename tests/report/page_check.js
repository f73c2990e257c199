// Runs inside of a page after its own script, as a reader would use it, and sends what it found to the page around it.
{
  const all = (selector) => [...document.querySelectorAll(selector)];
  const column = (n) => all(`#table tbody tr > :nth-child(${n})`).map((cell) => cell.textContent);
  const field = (label) => all("label.field").find((candidate) => candidate.firstChild.textContent === label);
  const choose = (label, value) => {
    const select = field(label).querySelector("select");
    select.value = value;
    select.dispatchEvent(new Event("change"));
  };
  const find = (text) => {
    const input = document.querySelector(".filters input");
    input.value = text;
    input.dispatchEvent(new Event("input"));
  };
  const sortBy = (id) => document.querySelector(`#table [data-column="${id}"]`).click();
  const plots = () => all(".plot").filter((plot) => plot.querySelector(":scope > svg"));
  const points = () => plots().map((plot) => plot.querySelectorAll(":scope > svg .point").length);

  const check = () => {
    const found = {
      points: points(),
      front: plots().map((plot) => [...plot.querySelectorAll(".best")].map((point) => point.getAttribute("aria-label"))),
      floors: all(".plot .floor").length,
      empty: all(".plot > .empty").map((line) => line.textContent),
      ticks: all(".plot text").map((text) => text.textContent),
      rows: all("#table tbody tr").length,
      reasons: all("#table td.reason").map((cell) => cell.textContent),
      images: all(".strip img").map((image) => image.naturalWidth),
      comparers: all(".compare").length,
      overflow: document.documentElement.scrollWidth - innerWidth,
      width: innerWidth,
      scripts: all("script").length,
      elements: all("h1, h2").map((title) => title.textContent),
      requests: performance.getEntriesByType("resource").map((entry) => entry.name).filter((name) => !name.startsWith("data:")),
      notNumbers: all("svg *").some((element) => [...element.attributes].some((a) => /NaN|Infinity|undefined/.test(a.value))),
      oddText: document.getElementById("main").innerText.match(/\bNaN\b|undefined|\bnull\b|\[object|\bfalse\b/g) || [],
      unlabelled: all("button, input, select, .point").filter((e) => !(e.textContent.trim() || e.getAttribute("aria-label") || e.closest("label"))).length,
      theme: document.documentElement.dataset.theme,
    };
    try {
      if (new URLSearchParams(location.search).has("use")) use(found);
    } catch (error) {
      found.failure = String(error.stack);
    }
    found.error = document.documentElement.dataset.error || "";
    parent.postMessage(JSON.stringify({ name: new URLSearchParams(location.search).get("name"), found }), "*");
  };

  const use = (found) => {
    sortBy("steady ");
    found.rising = column(6);
    sortBy("steady ");
    found.falling = column(6);
    sortBy("configuration");
    found.names = column(1);
    find("isotropic");
    found.filtered = column(1);
    found.faded = all(".plot .point:not(.faded)").map((point) => point.getAttribute("aria-label").split(":")[0]);
    find("no such thing");
    found.nothing = document.getElementById("table-count").textContent;
    find("");
    choose("Status", "failed");
    found.failed = column(1);
    choose("Status", "");
    choose("View", "1");
    found.inView = new Set(column(2)).size === 1 ? column(2)[0] : "several";

    const make = URL.createObjectURL;
    let blob = null;
    URL.createObjectURL = (given) => { blob = given; return "data:,"; };
    const click = HTMLAnchorElement.prototype.click;
    HTMLAnchorElement.prototype.click = function () { found.file = this.download; };
    document.getElementById("save").click();
    URL.createObjectURL = make, HTMLAnchorElement.prototype.click = click;
    found.csvBytes = blob.size;
    found.csv = csv().split("\r\n");
    choose("View", "");

    // By keyboard: from the first point to the next, then pick it.
    const first = document.querySelector(".plot .point[tabindex='0']");
    first.focus();
    first.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
    const second = document.activeElement;
    found.tip = document.querySelector(".tip.shown").textContent;
    second.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
    found.picked = second !== first && second.getAttribute("aria-pressed") === "true" && second.getAttribute("aria-label").split(":")[0];
    found.pickedInPictures = document.querySelector("#pictures-0 select").selectedOptions[0].textContent;

    choose("Frame", "first");
    choose("Error", "psnr");
    choose("Channel", "indirect_diffuse");
    choose("Time of", "light: bounce");
    found.ofPass = points();
    choose("Frame", "steady");
    found.ofAbsentPass = points();
    document.querySelector("#pictures-0 .heat").click();
    found.enlarged = document.getElementById("large").open && document.querySelectorAll("#large img").length;
    document.getElementById("large").close();
    for (const details of all("details")) details.open = true;
  };
  // Frames outside of the window get no animation frames.
  addEventListener("load", () => setTimeout(check, 200));
}
