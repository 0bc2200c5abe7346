// What the scripts of the pages find in their window.
// deno-lint-ignore-file no-explicit-any
/** The plots: vendor/uplot. */
declare const uPlot: any;
interface Window {
  cotree: any;
  cotreeDraw: any;
  cotreeServer: any;
  cotreeSolver: any;
}
