"use strict";
/* Columns of numbers from the data blocks of the page; rvjax/report/interactive/data_blocks.py writes them. */
const rvjax = {};

rvjax.blocks = (() => {
  const NAN = 65533,
    LOW = 65534,
    HIGH = 65535;

  const text = (id) => document.getElementById(id).textContent.trim();

  const json = (id) => {
    const element = document.getElementById(id);
    return element === null ? null : JSON.parse(element.textContent);
  };

  const bytes = (id) => Uint8Array.from(atob(text(id)), (character) => character.charCodeAt(0));

  /* Float64 numbers, little endian, without coding. */
  const plain = (id) => {
    const view = new DataView(bytes(id).buffer);
    return Float64Array.from({ length: view.byteLength / 8 }, (_, i) => view.getFloat64(8 * i, true));
  };

  const inflated = async (id) => {
    const stream = new Blob([bytes(id)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };

  /* High bytes, then low bytes, of zigzag coded differences → numbers. */
  const column = (data, begin, rows, offset, scale) => {
    const values = new Float64Array(rows);
    let code = 0;
    for (let i = 0; i < rows; i++) {
      const zigzag = data[begin + i] * 256 + data[begin + rows + i];
      code = (code + ((zigzag >>> 1) ^ -(zigzag & 1))) & 0xffff;
      values[i] = code < NAN ? offset + scale * code : code === NAN ? NaN : code === LOW ? -Infinity : Infinity;
    }
    return values;
  };

  /* name → numbers. head: {rows, columns: [[name, offset, scale]]}. */
  const read = async (id, head) => {
    const data = await inflated(id);
    const columns = {};
    head.columns.forEach(([name, offset, scale], place) => {
      columns[name] = column(data, 2 * place * head.rows, head.rows, offset, scale);
    });
    return columns;
  };

  return { json, plain, read, known: () => typeof DecompressionStream === "function" };
})();
