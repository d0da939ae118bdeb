"use strict";
/* The exact interval of a share (Clopper and Pearson, 1934), by the incomplete beta function and its inverse. */
rvjax.statistics = (() => {
  /* ln Γ(x), x > 0: Lanczos' series with g = 7 and nine terms, relative error about 1e-15. */
  const LANCZOS = [
    0.99999999999980993, 676.5203681218851, -1259.1392167224028, 771.32342877765313, -176.61502916214059, 12.507343278686905,
    -0.13857109526572012, 9.9843695780195716e-6, 1.5056327351493116e-7,
  ];
  const logGamma = (x) => {
    if (x < 0.5) return Math.log(Math.PI / Math.sin(Math.PI * x)) - logGamma(1 - x);
    const base = x + 6.5;
    const sum = LANCZOS.reduce((total, term, i) => total + (i ? term / (x - 1 + i) : term), 0);
    return 0.5 * Math.log(2 * Math.PI) + (x - 0.5) * Math.log(base) - base + Math.log(sum);
  };

  /* The continued fraction of I_x(a, b), by the method of Lentz. */
  const fraction = (a, b, x) => {
    const TINY = 1e-300;
    const kept = (value) => (Math.abs(value) < TINY ? TINY : value);
    let d = 1 / kept(1 - ((a + b) * x) / (a + 1)),
      c = 1,
      result = d;
    for (let m = 1; m < 100000; m++) {
      const even = (m * (b - m) * x) / ((a + 2 * m - 1) * (a + 2 * m));
      d = 1 / kept(1 + even * d);
      c = kept(1 + even / c);
      result *= d * c;
      const odd = (-(a + m) * (a + b + m) * x) / ((a + 2 * m) * (a + 2 * m + 1));
      d = 1 / kept(1 + odd * d);
      c = kept(1 + odd / c);
      result *= d * c;
      if (Math.abs(d * c - 1) < 1e-15) break;
    }
    return result;
  };

  /* I_x(a, b): the distribution function of the beta distribution. */
  const incompleteBeta = (a, b, x) => {
    if (x <= 0) return 0;
    if (x >= 1) return 1;
    const front = Math.exp(logGamma(a + b) - logGamma(a) - logGamma(b) + a * Math.log(x) + b * Math.log1p(-x));
    return x < (a + 1) / (a + b + 2) ? (front * fraction(a, b, x)) / a : 1 - (front * fraction(b, a, 1 - x)) / b;
  };

  /* x with I_x(a, b) = p: bisection until no float lies between the ends. */
  const betaQuantile = (a, b, p) => {
    let low = 0,
      high = 1;
    for (let i = 0; i < 1100; i++) {
      const middle = low + (high - low) / 2;
      if (middle <= low || middle >= high) break;
      if (incompleteBeta(a, b, middle) < p) low = middle;
      else high = middle;
      if (high - low < 1e-15 * high) break;
    }
    return low + (high - low) / 2;
  };

  /* [low, high] of the share with k successes among n; of none: [0, 1]. */
  const clopperPearson = (k, n, confidence) => {
    if (n === 0) return [0, 1];
    const tail = (1 - confidence) / 2;
    return [k === 0 ? 0 : betaQuantile(k, n - k + 1, tail), k === n ? 1 : 1 - betaQuantile(n - k, k + 1, tail)];
  };

  return { logGamma, incompleteBeta, betaQuantile, clopperPearson };
})();
