/** The plots against time, the eye diagram and the histogram of causes. */
export function Plots() {
  return <section class="plots" aria-label="Plots" />;
}
