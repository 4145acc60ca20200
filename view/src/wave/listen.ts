/** Listens to events of an element until the function that it returns is called. */
export function listen(
  element: HTMLElement,
  listeners: { [Name in keyof HTMLElementEventMap]?: (event: HTMLElementEventMap[Name]) => void },
): () => void {
  const stop = new AbortController();
  for (const [name, listener] of Object.entries(listeners)) {
    element.addEventListener(name, listener as EventListener, { passive: false, signal: stop.signal });
  }
  return () => stop.abort();
}
