"use strict";
/* Shows what the page has data for, once it is loaded. */
(async () => {
  if (!rvjax.blocks.known()) return;
  const at = (id) => document.getElementById(id);
  const reveal = (id) =>
    document.querySelectorAll(`#${id}, [data-live="${id}"]`).forEach((element) => {
      element.hidden = false;
    });
  const about = rvjax.blocks.json("replay-about"),
    samples = rvjax.blocks.json("samples-about");
  let controls = null;
  if (about !== null) {
    reveal("replay");
    const replay = new rvjax.replay.Replay(about, { scene: at("scene"), names: at("scene-names") });
    controls = new rvjax.controls.Controls(replay, samples.folder);
    rvjax.shown = replay;
    const wanted = rvjax.controls.address();
    if (wanted === null || !(await controls.follow(true))) await replay.open(about.flights[0].sample, 0);
    controls.touched = false;
    replay.draw();
  }
  reveal("brushing");
  const read = new rvjax.samples.Samples(samples, await rvjax.blocks.read("samples-data", samples.block));
  const opened = async (sample) => {
    const kept = controls !== null && (await controls.open(sample, 0));
    if (kept) at("replay").scrollIntoView({ block: "start", behavior: "instant" });
    return kept;
  };
  const command = (sample) => rvjax.controls.command(samples.folder, sample);
  rvjax.linked = new rvjax.brushing.Brushing(read, opened, command);
  rvjax.ready = performance.now();
})();
